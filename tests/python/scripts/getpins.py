from common import *

h = hal.component("c")
print(h.getpins(), len(h))
h.newpin("z", BIT, OUT)
h.newpin("a", FLOAT, OUT).set(2.5)
h.newparam("m", S32, RW).set(-3)
h.ready()
print(h.getpins(), len(h))
