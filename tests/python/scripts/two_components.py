from common import *

a, b = hal.component("a"), hal.component("b")
o = a.newpin("o", U32, OUT)
i = b.newpin("i", U32, IN)
a.ready()
b.ready()
hal.new_sig("s", U32)
hal.connect("a.o", "s")
hal.connect("b.i", "s")
for n in 0, 1, 2**32 - 1, 17:
    o.set(n)
    settle()
    print(i.get(), b["i"], b.i)
a.exit()
print(hal.component_exists("a"), hal.component_exists("b"), i.get())
