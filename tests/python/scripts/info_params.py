from common import *

h = hal.component("c")
for name, ty, d in ("z", BIT, RO), ("a", FLOAT, RW), ("m", S32, RO), ("k", U32, RW):
    h.newparam(name, ty, d)
h.ready()
h["z"], h["a"], h["m"], h["k"] = 1, 2.5, -4, 9
for row in hal.get_info_params():
    print(row)
