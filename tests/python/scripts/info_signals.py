from common import *

h = hal.component("c")
h.newpin("o", FLOAT, OUT)
h.newpin("i", FLOAT, IN)
h.newpin("io", S32, IO)
h.ready()
for name, ty in ("s2", FLOAT), ("s1", BIT), ("s3", S32):
    hal.new_sig(name, ty)
hal.connect("c.o", "s2")
hal.connect("c.i", "s2")
hal.connect("c.io", "s3")
h["o"] = 1.5
for row in hal.get_info_signals():
    print(row)
