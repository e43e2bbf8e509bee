#!/usr/bin/python3
"""LinuxCNC's display for `peer.sh`: homes the machine, writes the positions of its joints to a file, and ends."""
import linuxcnc
import subprocess
import sys
import time

command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
time.sleep(1)
command.state(linuxcnc.STATE_ESTOP_RESET)
command.wait_complete()
command.state(linuxcnc.STATE_ON)
command.wait_complete()
command.home(-1)
for _ in range(6000):
    status.poll()
    said = errors.poll()
    if said:
        sys.exit(said[1])
    if all(status.homed[:3]) and status.inpos:
        break
    time.sleep(0.01)
else:
    sys.exit("not homed after a minute")
time.sleep(0.5)
with open("homed", "w") as out:
    for joint in range(3):
        for pin in ["pos-cmd", "motor-offset", "motor-pos-cmd"]:
            name = f"joint.{joint}.{pin}"
            value = subprocess.run(["halcmd", "getp", name], check=True, capture_output=True, text=True)
            print(name, value.stdout.strip(), file=out)
