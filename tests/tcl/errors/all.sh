for f in line proc sourced other syntax ended missing killed; do
  echo "$f"
  halrun --instance b --virtual -f $f.tcl 2>&1 </dev/null
  echo "status $?"
done
halrun --instance b --virtual -Q -f line.tcl 2>&1 </dev/null
echo "status $?"
