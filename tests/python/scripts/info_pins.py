from common import *

h = hal.component("c")
for name, ty, d in ("z", BIT, OUT), ("a", FLOAT, IN), ("m", S32, IO), ("k", U32, OUT):
    h.newpin(name, ty, d)
h.ready()
h["z"], h["m"], h["k"] = 1, -4, 9
for row in hal.get_info_pins():
    print(row)
