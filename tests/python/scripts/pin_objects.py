from common import *

h = hal.component("c")
p = h.newpin("p", FLOAT, OUT)
q = h.newparam("q", S32, RO)
h.ready()
for x in p, q:
    print(type(x).__name__, type(x).__module__, x.name, x.type, x.dir, x.value, x.__repr__())
    x.value = 6
    print(x.value, x.get())
    x.note = "mine"
    print(x.note)
    for name in "name", "type", "dir":
        try:
            setattr(x, name, 1)
        except AttributeError:
            print(name, "cannot be set")
    print(hasattr(x, "nothing"))
show("set without value", lambda: p.set())
show("set two values", lambda: p.set(1, 2))
show("text", lambda: setattr(p, "value", "x"))
print(p == p, p != q, hash(p) == hash(p))
