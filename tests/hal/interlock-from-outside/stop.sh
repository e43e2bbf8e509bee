exec 2>&1
halcmd iocontrol.estop
echo "status $?"
halcmd --json iocontrol.estop
echo "status $?"
