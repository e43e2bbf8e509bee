try() {
  echo "$*"
  "$@" 2>&1 </dev/null
  echo "status $?"
}
try halrun --instance b -z x.hal
try halrun --instance b --for 5 x.hal
try halrun --instance b --fro 5s x.hal
try halrun --instance b a.hal b.hal
try halrun --instance b a.txt
try halrun --instance b not-there.tcl
try halrun --instance b not-there.hal
try halrun --instance b -i not-there.ini -f test.hal
try halrun --instance a/b test.hal
try halrun --instance b --virtual --record /no/such/folder/x -f one.hal
try halrun -f test.hal
try halrun --instance b -U
try halcmd --instance nobody getp x
try halcmd -z
try halcmd -f not-there.hal
try halcmd -i x.ini getp x
try halcmd nonsense
try halcmd print '$HOME'
try halcmd -h nonsense
try halcmd -h addf
try halsampler -z
try halstreamer a b
try halrun --instance b --hold=1 x.hal
try halrun --instance b --for
try halrun --instance b -i
try halrun
try halcmd -Q linkps a b
try halcmd -i no.ini -f one.hal
try halcmd -k -f two.hal
try halcmd -v -k -f two.hal
try halcmd -kQ -f two.hal
