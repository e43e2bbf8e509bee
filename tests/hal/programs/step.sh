echo "step $1"
[ "$1" = kill ] && kill -9 $$
exit "$1"
