for f in forms differ first second load; do
  echo "$f"
  halrun --instance b --virtual --headless --for 1ms $f.ini 2>&1 </dev/null
  echo "status $?"
done
