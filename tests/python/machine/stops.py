"""A program that stops a machine without a task in each way, and says what the machine then does."""
import time

import _machine
import linuxcnc

channel = _machine.Channel()
motion = _machine.Page(channel, "motion.status")
command = linuxcnc.command()
stat = linuxcnc.stat()
states = {linuxcnc.STATE_ESTOP: "e-stop", linuxcnc.STATE_ESTOP_RESET: "off", linuxcnc.STATE_ON: "on"}


def until(is_so):
    """Waits until motion is so; the script's time limit ends a machine that never is."""
    while True:
        motion.poll()
        if is_so():
            return
        time.sleep(0.005)


def done():
    return command.wait_complete(60) == linuxcnc.RCS_DONE


def rests():
    """Returns whether the path does not move on in 50 cycles."""
    motion.poll()
    before, cycle = motion["pose"][0], motion["cycle"]
    until(lambda: motion["cycle"] > cycle + 50)
    return motion["pose"][0] == before


for name, stop in [
    ("estop", lambda: command.state(linuxcnc.STATE_ESTOP)),
    ("off", lambda: command.state(linuxcnc.STATE_OFF)),
    ("abort", command.abort),
    ("pause", lambda: command.auto(linuxcnc.AUTO_PAUSE)),
]:
    motion.poll()
    if motion["estop"]:
        command.state(linuxcnc.STATE_ESTOP_RESET)
        assert done()
    command.state(linuxcnc.STATE_ON)
    assert done()
    command.home(-1)
    assert done()
    to = -500 if motion["pose"][0] > -400 else -300
    channel.command("motion.move", "x=%d" % to, "velocity=3")
    until(lambda: motion["velocity"] > 2.9)
    stop()
    assert done()
    until(lambda: motion["velocity"] == 0.0)
    print(name, "rests", rests(), "on", motion["enabled"], "e-stop", motion["estop"], "queue", motion["queue"])
    stat.poll()
    print(states[stat.task_state], bool(stat.estop), stat.task_mode == linuxcnc.MODE_MANUAL, stat.paused,
          stat.interp_state == linuxcnc.INTERP_IDLE, stat.wait, stat.feedrate, repr(stat.file), len(stat.position))
# Each field that motion knows in the place of a task is one of its record.
print("fields", sorted(linuxcnc._pages._FROM_MOTION), all(stat._task[name] is not None for name in linuxcnc._pages._FROM_MOTION))
command.auto(linuxcnc.AUTO_RESUME)
assert done()
until(lambda: motion["velocity"] > 2.9)
print("resumed")
command.auto(linuxcnc.AUTO_RUN)
print(command.wait_complete(), linuxcnc._messages.own[-1][1])
print(linuxcnc.error_channel().poll()[0] == linuxcnc.OPERATOR_ERROR)
command.abort()
