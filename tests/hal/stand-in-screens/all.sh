halrun --instance b --virtual --headless --run job.ngc machine.ini 2>&1 </dev/null
echo "status $?"
echo "-- on the real clock they stay 0"
halrun --instance b --headless --for 10ms machine.ini 2>&1 </dev/null
echo "status $?"
sed "s|^net go .*|net go panel.go => joint.0.amp-fault-in|" machine.hal > stopped.hal
sed "s|machine.hal|stopped.hal|" machine.ini > stopped.ini
echo "-- and what stops the machine may not depend on them"
halrun --instance b --headless --for 10ms stopped.ini 2>&1 </dev/null
echo "status $?"
rm -f *.var *.spindle stopped.*
