from common import *

h = hal.component("c")
pins = [h.newpin(f"p{n}", S32, OUT) for n in range(300)]
for n, p in enumerate(pins):
    p.set(n * n)
h.ready()
print(sum(p.get() for p in pins), hal.get_value("c.p299"), len(h))
