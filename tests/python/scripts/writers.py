from common import *

h = hal.component("c")
for name, d in ("o", OUT), ("i", IN), ("j", IN), ("io", IO):
    h.newpin(name, S32, d)
h.ready()
def writers():
    print([hal.pin_has_writer("c." + n) for n in ("o", "i", "j", "io")])
writers()
hal.new_sig("s", S32)
hal.connect("c.i", "s")
writers()
hal.connect("c.o", "s")
writers()
hal.new_sig("t", S32)
hal.connect("c.io", "t")
hal.connect("c.j", "t")
writers()
show("none", lambda: hal.pin_has_writer("zz"))
