from common import *

h = hal.component("c")
for name, ty, v in ("b", BIT, 1), ("f", FLOAT, 1.25), ("s", S32, -5), ("u", U32, 4000000000):
    h.newpin(name, ty, OUT).set(v)
    h.newparam("p" + name, ty, RW).set(v)
h.ready()
for name in "bfsu":
    print(repr(hal.get_value("c." + name)), repr(hal.get_value("c.p" + name)))
show("none", lambda: hal.get_value("zz"))
show("no argument", lambda: hal.get_value())
