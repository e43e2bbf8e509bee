#!/bin/sh
# Runs parport.hal through the LinuxCNC that is installed, as an ordinary user and without a port,
# and keeps what it wrote to the registers in each period: by `write / reset`.
here=$(cd "$(dirname "$0")" && pwd) || exit 1
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cp "$here/parport.hal" "$here/parport.in" "$work" || exit 1
cc -O1 -shared -fPIC -o "$work/ports.so" "$here/ports.c" || exit 1
# A copy has no right to the ports, so that an access to them faults.
cp "$(command -v rtapi_app)" "$work/rtapi_app" && chmod 755 "$work" "$work/rtapi_app"
cat > "$work/go" <<'GO'
cd "$1" || exit 1
export HOME="$1"
halrun -U
# One module keeps the copy alive; every later one is loaded by it.
PORTS_LOG="$1/log" LD_PRELOAD="$1/ports.so" ./rtapi_app load constant &
until halcmd show comp 2> /dev/null | grep -q constant; do :; done
halcmd -f parport.hal
halcmd getp parport.0.reset-time > reset-time
halcmd stop
halcmd unload all
./rtapi_app exit
wait
halrun -U
GO
if [ "$(id -u)" = 0 ]; then
    chown -R nobody "$work"
    user="runuser -u nobody --"
fi
timeout 60 $user sh "$work/go" "$work" > "$work/out" 2>&1
# A read begins each half period: the first the written one, the second the reset one.
awk -v rows="$(wc -l < "$here/parport.in")" '
/^r/ { if (half++ && half % 2) { print line; line = "" } else if (half > 1) line = line " /"; next }
{ line = line (line == "" ? "" : " ") $2 }
' "$work/log" | head -n "$(wc -l < "$here/parport.in")" > "$here/parport.out"
[ -s "$here/parport.out" ] || { cat "$work/out"; exit 1; }
echo "reset-time $(cat "$work/reset-time")"
