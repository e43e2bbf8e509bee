from common import *

h = hal.component("c")
for name, ty in ("bit", BIT), ("float", FLOAT), ("s32", S32), ("u32", U32):
    for end, d in ("in", IN), ("out", OUT), ("io", IO):
        p = h.newpin(f"{name}.{end}", ty, d)
        print(p.get_name(), p.get_type(), p.get_dir(), p.is_pin(), repr(p.get()))
h.ready()
