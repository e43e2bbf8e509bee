for f in missing syntax nosuch; do
  echo "$f"
  halrun --instance b --virtual --for 1ms $f.ini 2>&1
  echo "status $?"
done
