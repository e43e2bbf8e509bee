halrun --instance b --virtual --headless --for 1ms m.ini 2>&1 </dev/null
echo "status $?"
halcmd check m.ini
echo "status $?"
