"""Bounds of the module linuxcnc: overrides, commands and messages that wait, axes, and messages that were not shown."""
import linuxcnc
from linuxcnc import _messages

command, errors, status = linuxcnc.command(), linuxcnc.error_channel(), linuxcnc.stat()


def complete(name, *args):
    getattr(command, name)(*args)
    return command.wait_complete()


def flood(count, name, *args):
    """Sends many commands and returns the largest numbers of commands and of messages that waited."""
    most = [0, 0]
    for _ in range(count):
        getattr(command, name)(*args)
        most = [max(most[0], len(_messages.pending)), max(most[1], len(_messages.own))]
    return most


def drain():
    """Takes all messages and returns their number and the last one."""
    count, last = 0, None
    while (message := errors.poll()) is not None:
        count, last = count + 1, message
    return count, last


for axis in (-1, 9):
    for what in (linuxcnc.JOG_STOP, linuxcnc.JOG_CONTINUOUS):
        try:
            command.jog(what, False, axis, 5)
            print("jogs axis", axis)
        except linuxcnc.error as why:
            print(why)
print("reset", complete("state", linuxcnc.STATE_ESTOP_RESET))
print("on", complete("state", linuxcnc.STATE_ON))
print("home", complete("home", -1))
for rapid in (0.25, 1.5, -1, 0.5):
    done = complete("rapidrate", rapid), complete("feedrate", 0.75)
    status.poll()
    print("rapid override", rapid, *done, status.rapidrate, status.feedrate)
print("mdi", complete("mode", linuxcnc.MODE_MDI))

# In virtual time no command ends while the program sends the next one.
most = flood(300, "set_digital_output", 0, 1)
print("waiting:", most, _messages.MAX_WAITING)
# The task's queue refuses what it cannot take, each time with a message.
most = flood(300, "mdi", "G4 P1000")
print("messages:", most[1], most[0] <= _messages.MAX_WAITING)
print("abort", complete("abort"))
drain()

print("mdi", complete("mode", linuxcnc.MODE_MDI))
for text in ("first", "second", "third", "fourth"):
    complete("mdi", "(MSG,%s)" % text)
print(errors.poll(), errors.poll(), errors.poll())
