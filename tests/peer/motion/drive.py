#!/usr/bin/python3
"""LinuxCNC's display for `peer::motion`: runs the programs named in PROGRAMS, one after the other, and ends."""
import linuxcnc
import os
import re
import subprocess
import sys
import time

command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()


def wait(what, done):
    """Polls until `done`; an error message of the machine ends the run."""
    for _ in range(60000):
        status.poll()
        said = errors.poll()
        if said:
            sys.exit(f"{what}: {said[1]}")
        if done():
            return
        time.sleep(0.005)
    sys.exit(f"{what}: not done after five minutes")


def at_rest():
    return status.interp_state == linuxcnc.INTERP_IDLE and status.inpos and status.queue == 0


def override(feed, rapid):
    command.feedrate(feed)
    command.wait_complete()
    command.rapidrate(rapid)
    command.wait_complete()


def overrides_of(program):
    """Returns the overrides of feeds and rapid moves that the first line of a program names."""
    with open(program) as lines:
        found = re.match(r"\(overrides: feed (\S+), rapid (\S+)\)", lines.readline())
    return [float(scale) for scale in found.groups()] if found else [1.0, 1.0]


def mark(number):
    subprocess.run(["halcmd", "sets", "program", str(number)], check=True)


time.sleep(1)
command.state(linuxcnc.STATE_ESTOP_RESET)
command.wait_complete()
command.state(linuxcnc.STATE_ON)
command.wait_complete()
command.home(-1)
wait("homing", lambda: all(status.homed[:5]))
with open("samples", "w") as samples:
    sampler = subprocess.Popen(["halsampler"], stdout=samples)
    for number, program in enumerate(os.environ["PROGRAMS"].split(), 1):
        command.mode(linuxcnc.MODE_MDI)
        command.wait_complete()
        override(1.0, 1.0)
        command.mdi("G90 G0 X0 Y0 Z0 A0 B0")
        command.wait_complete()
        wait("the way back", at_rest)
        command.mode(linuxcnc.MODE_AUTO)
        command.wait_complete()
        command.program_open(os.path.abspath(program))
        override(*overrides_of(program))
        mark(number)
        command.auto(linuxcnc.AUTO_RUN, 0)
        wait("the start", lambda: status.interp_state != linuxcnc.INTERP_IDLE)
        wait(program, at_rest)
        time.sleep(0.3)
        mark(0)
    sampler.terminate()
    sampler.wait()
