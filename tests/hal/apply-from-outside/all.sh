exec 2>&1
printf 'loadrt or2\nnet x or2.0.out and2.0.in0\n' | halcmd -v apply -
echo "status $?"
printf 'newsig y bit\nsetp and2.0.in1 1\nsetp and2.5.in1 1\n' | halcmd apply -
echo "status $?"
printf 'setp or2.0.in1 [A]B\naddf or2.0 fast 1\n' > file.hal
printf '[A]\nB = 1\n' > file.ini
halcmd apply --dry-run -i file.ini file.hal
halcmd --json apply --dry-run -i file.ini file.hal
halcmd -v apply -i file.ini file.hal
echo "status $?"
i=0
while [ $i -lt 300 ]; do echo "setp and2.1.in0 1"; i=$((i + 1)); done > long.hal
halcmd -v apply long.hal
echo "status $?"
rm file.hal file.ini long.hal
