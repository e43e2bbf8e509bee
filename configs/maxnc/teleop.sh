#!/bin/sh
# The mill driven from afar, in real time and simulated: sh teleop.sh (about half a minute).
set -eu
cd "$(dirname "$0")"
HAL_RUNTIME_DIR=$(mktemp -d)
export HAL_RUNTIME_DIR
part=$HAL_RUNTIME_DIR/part.ngc
halrun --simulate --headless teleop.ini &
machine=$!
panel=
trap 'kill $panel $machine 2>/dev/null || true; wait; rm -rf "$HAL_RUNTIME_DIR" teleop.journal' EXIT
until halcmd task.status >/dev/null 2>&1; do sleep 0.2; done
halpanel --listen 127.0.0.1:0 --ini-file teleop.ini --programs "$HAL_RUNTIME_DIR" &
panel=$!
until [ "$(halcmd getp teleop.listening 2>/dev/null || echo 0)" != 0 ]; do sleep 0.2; done

echo "The operator switches the mill on, and calls the place where it stands zero (Ajustar)."
halcmd task.estop-reset --wait
halcmd task.on --wait
halcmd task.home joint=all --wait

echo "A user sends a part and runs it; a second one looks on."
printf 'G20 G90\nG1 X0.5 Y0.25 F14\nG2 X1 Y0.75 I0 J0.5\nG1 X0 Y0\nM2\n' >"$part"
halteleop --user ana run "$part" &
user=$!
sleep 5
echo "eva asks: $(halteleop --user eva --quiet progress)"
wait $user
halcmd show pin stepgen.*.counts

echo "The operator stops the server (Detener servidor)."
halcmd setp teleop.serve FALSE
