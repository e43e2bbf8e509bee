from common import *

h = hal.component("c")
for name, ty in ("b", BIT), ("f", FLOAT), ("s", S32), ("u", U32):
    h.newpin(name, ty, IN)
    h.newparam("p" + name, ty, RW)
h.newpin("o", BIT, OUT)
h.newparam("ro", BIT, RO)
h.ready()
for name, v in ("b", "1"), ("b", "FALSE"), ("b", "true"), ("b", "x"), ("f", "1.5"), ("f", "-1e3"), ("f", "x"), ("s", "-7"), ("s", "x"), ("s", "0x10"), ("u", "9"), ("u", "x"):
    show(f"c.{name} {v}", lambda: hal.set_p("c." + name, v))
    settle()
    print("  ", repr(h[name]))
    show(f"c.p{name} {v}", lambda: hal.set_p("c.p" + name, v))
    settle()
    print("  ", repr(h["p" + name]))
show("output", lambda: hal.set_p("c.o", "1"))
show("read-only", lambda: hal.set_p("c.ro", "1"))
show("none", lambda: hal.set_p("zz", "1"))
show("not a text", lambda: hal.set_p("c.b", 1))
hal.new_sig("s", BIT)
hal.connect("c.b", "s")
show("linked", lambda: hal.set_p("c.b", "1"))
show("signal", lambda: hal.set_p("s", "1"))
