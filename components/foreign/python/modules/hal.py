"""Components, pins, signals and streams of a Ferrule instance.

A program that `loadusr` starts joins the instance that started it:

    import hal, time
    h = hal.component("doubler")
    h.newpin("in", hal.HAL_FLOAT, hal.HAL_IN)
    h.newpin("out", hal.HAL_FLOAT, hal.HAL_OUT)
    h.ready()
    while True:
        h["out"] = 2 * h["in"]
        time.sleep(0.01)
"""

from _hal import *
import _hal


class component(_hal.component):
    """A component of this program, with its pins and parameters.

    Pins are read and written as items (`h["in"]`) or as attributes (`h.out = 1`).
    """

    def __init__(self, name, prefix=None):
        self._join(name, prefix)

    # Python looks for an attribute in the class first, then in __dict__, then here.
    __getattr__ = _hal.component.__getitem__
    __iter__ = None

    def __setattr__(self, name, value):
        self[name] = value
