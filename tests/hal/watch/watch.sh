halcmd watch --count 1 x not.0.in
halcmd watch --count 2 -n 1ms '*.in' not.0.out
halcmd watch not.0.i --count 1
halcmd meter not.0.inn
echo "status $?"
halcmd watch
halcmd watch --count x y
halcmd watch -n 5 y
halcmd meter
