for f in good wrong outside asked caught endless ended reads; do
  echo "$f"
  halcmd check $f.tcl after.hal
  echo "status $?"
done
ls
