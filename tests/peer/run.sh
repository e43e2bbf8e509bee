#!/bin/sh
# Runs one script through the LinuxCNC that is installed, as an ordinary user, and keeps the
# samples: sh run.sh NAME [TRIES]
# A script with two threads is repeated until every period of the slow one held ten of the fast one.
here=$(cd "$(dirname "$0")" && pwd) || exit 1
name=$1
tries=${2:-400}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cp "$here/$name.hal" "$here"/*.in "$work" || exit 1
if [ "$(id -u)" = 0 ]; then
    chown -R nobody "$work"
    user="runuser -u nobody --"
fi
while [ "$tries" -gt 0 ]; do
    tries=$((tries - 1))
    (cd "$work" && rm -f *.raw && timeout 60 $user env HOME="$work" halrun -f "$name.hal") > "$work/log" 2>&1
    status=$?
    if [ $status -ne 0 ]; then
        cat "$work/log"
        exit $status
    fi
    cat "$work"/*.raw | grep -q overrun && continue
    paste -d '' "$work"/*.raw | sed 's/ *$//' > "$work/all"
    grep -q '^net tick' "$here/$name.hal" || { cp "$work/all" "$here/$name.out"; exit 0; }
    # From the first slow period on, whole ones only; the first must not have begun late.
    awk -f "$here/cut.awk" "$work/all" > "$here/$name.out" && exit 0
done
echo "no run was regular" >&2
exit 1
