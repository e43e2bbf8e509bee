#!/bin/sh
# Makes listings.out and refusals.err with LinuxCNC, as an ordinary user, where it is installed.
cd "$(dirname "$0")" || exit 1
halrun -k -f listings.hal >listings.out 2>/dev/null </dev/null
halrun -k -f refusals.hal 2>&1 >/dev/null </dev/null | grep -v '^Note:\|^<commandline>\|^or2: not' >refusals.err
