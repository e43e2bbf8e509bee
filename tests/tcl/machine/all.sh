export HALLIB_PATH=$PWD
halrun --instance b --virtual --headless --for 5ms m.ini 2>&1 </dev/null
echo "status $?"
halrun --instance b --virtual -i m.ini -f alone.tcl 2>&1 </dev/null
echo "status $?"
