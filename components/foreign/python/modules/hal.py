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


class _ItemWrap:
    """A pin or parameter in Python, so that classes can have it as a base beside one of another library."""

    def __init__(self, item):
        item = getattr(item, "_item", item)
        if not isinstance(item, _hal.item):
            raise TypeError("Constructor argument must be _hal.item: %s" % type(item))
        self._item = item
        self._item_wrap(item)

    def _item_wrap(self, item):
        """Takes over the methods of an item."""
        for name in ("get", "set", "get_type", "get_dir", "get_name", "is_pin"):
            setattr(self, name, getattr(item, name))

    def __repr__(self):
        return repr(self._item)

    name = property(lambda self: self._item.get_name(), doc="Name, without the component's prefix.")
    type = property(lambda self: self._item.get_type(), doc="Type, such as `HAL_FLOAT`.")
    dir = property(lambda self: self._item.get_dir(), doc="Direction, such as `HAL_IN`.")
    value = property(lambda self: self.get(), lambda self, value: self.set(value), doc="Value.")


class Pin(_ItemWrap):
    """Pin of a component."""


class Param(_ItemWrap):
    """Parameter of a component."""


class component(_hal.component):
    """A component of this program, with its pins and parameters.

    Pins are read and written as items (`h["in"]`) or as attributes (`h.out = 1`).
    """

    def __init__(self, name, prefix=None):
        self._join(name, prefix)

    def newpin(self, *args, **kw):
        """newpin(NAME, TYPE, DIRECTION): creates a pin."""
        return Pin(super().newpin(*args, **kw))

    def newparam(self, *args, **kw):
        """newparam(NAME, TYPE, DIRECTION): creates a parameter."""
        return Param(super().newparam(*args, **kw))

    def getpin(self, *args, **kw):
        """getpin(NAME): returns a pin."""
        return Pin(super().getpin(*args, **kw))

    def getparam(self, *args, **kw):
        """getparam(NAME): returns a parameter."""
        return Param(super().getparam(*args, **kw))

    # Python looks for an attribute in the class first, then in __dict__, then here.
    __getattr__ = _hal.component.__getitem__
    __iter__ = None

    def __setattr__(self, name, value):
        self[name] = value
