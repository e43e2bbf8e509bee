"""A program that a HAL file starts on a machine without a task: e-stop while it starts, then an error; one connection."""
import os
import time

import hal
import linuxcnc


def connections():
    """Returns the number of sockets that this process has open."""
    links = ("/proc/self/fd/" + name for name in os.listdir("/proc/self/fd"))
    return sum(os.path.islink(link) and os.readlink(link).startswith("socket:") for link in links)


def failure(poll):
    try:
        poll()
    except linuxcnc.error as why:
        return why
    return None


component = hal.component("taskless")
component.newpin("polls", hal.HAL_U32, hal.HAL_OUT)
component.ready()
before = connections()
stat = linuxcnc.stat()
stat.poll()
print("e-stop", stat.estop, stat.task_state == linuxcnc.STATE_ESTOP, connections() - before)
made = []
channel = linuxcnc._stat._machine.Channel
linuxcnc._stat._machine.Channel = lambda: made.append(None) or channel()
polls = 0
while not failure(stat.poll):
    polls += 1
    time.sleep(0.01)
print("polls in between", polls > 0)
for _ in range(3):
    print(failure(stat.poll))
print("connections", connections() - before, len(made))
errors = linuxcnc.error_channel()
print(failure(errors.poll) is not None, len(made))
print("the last state", stat.estop)
