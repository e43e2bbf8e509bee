# Each is a machine without its hardware.
echo "-- nothing is replaced: what would be"
halrun --instance b --virtual --run thread.ngc mill.ini 2>&1 </dev/null
echo "status $?"
echo "-- everything that is not there"
halrun --instance b --virtual --stub missing --run thread.ngc mill.ini 2>&1 </dev/null
echo "status $?"
echo "-- by name, and as the INI file says"
cp mill.ini named.ini
sed -i 's/^HALFILE/STUB = hostmot2 hm2_pci\nHALFILE/' named.ini
halrun --instance b --virtual --run thread.ngc named.ini 2>&1 </dev/null
echo "status $?"
echo "-- check knows it"
halcmd check --level warning named.ini
echo "-- the real clock"
halrun --instance b --headless --for 100ms --stub hostmot2,hm2_pci,gs2_vfd,xhc-whb04b-6,dial.py,vfdmod mill.ini 2>&1 | grep -v 'stand-in pin'
echo "status $?"
echo "-- a script"
halrun --instance b --virtual --stub hostmot2,hm2_pci -f script.hal 2>&1 </dev/null
echo "status $?"
echo "-- a mistake"
halrun --instance b --virtual --stub missing,lcecc -f misspelt.hal 2>&1 </dev/null
echo "status $?"
echo "-- the parts, and the page of a trial, which leaves nothing behind"
rm -f *.var *.spindle named.ini
halcmd check --parts mill.ini
ferrule try mill.ini 2>&1 </dev/null
echo "status $?"
ls
rm -f *.var *.spindle named.ini
