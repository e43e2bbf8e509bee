haltcl -i m.ini x.tcl one 'two words' 2>&1
echo "status $?"
haltcl wrong.tcl 2>&1
echo "status $?"
tclsh plain.tcl 2>&1
echo "status $?"
haltcl --instance nobody x.tcl 2>&1
echo "status $?"
printf 'getp and2.0.in0\nexpr 6 *\\\n 7\nsetp and2.0.in7 1\nnosuch\n' | haltcl 2>&1
echo
haltcl -z 2>&1
echo "status $?"
haltcl -i not-there.ini x.tcl 2>&1
echo "status $?"
haltcl not-there.tcl 2>&1
echo "status $?"
