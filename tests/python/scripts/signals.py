from common import *

h = hal.component("c")
h.ready()
for name, ty in ("b", BIT), ("f", FLOAT), ("s", S32), ("u", U32):
    show(name, lambda: hal.new_sig(name, ty))
    show("  value", lambda: hal.get_value(name))
show("duplicate", lambda: hal.new_sig("b", BIT))
show("type", lambda: hal.new_sig("x", 99))
show("no type", lambda: hal.new_sig("x"))
show("text as type", lambda: hal.new_sig("x", "bit"))
print(hal.get_info_signals())
