"""A program that a HAL file starts before the task: the state is blank, and then that of the machine."""
import time

import hal
import linuxcnc
from linuxcnc import _pages

stat, errors = linuxcnc.stat(), linuxcnc.error_channel()


def fields():
    stat.poll()
    names = [name for name in dir(stat) if not name.startswith("_") and name != "poll"]
    return {name: getattr(stat, name) for name in names}


def shape(value):
    if isinstance(value, dict):
        return {name: shape(v) for name, v in value.items()}
    if isinstance(value, tuple):
        return [shape(v) for v in value]
    return type(value).__name__


def shown(state):
    return [state[name] for name in ("task_state", "estop", "homed", "file", "queue", "g5x_index", "feedrate")]


before = fields()
print("before", shown(before), errors.poll())
component = hal.component("early")
component.ready()
while any(isinstance(page, _pages.Blank) for page in stat._pages):
    time.sleep(0.01)
    stat.poll()
after = fields()
print("after", shown(after), errors.poll())
print("of another shape:", [name for name in before if shape(before[name]) != shape(after[name])])
