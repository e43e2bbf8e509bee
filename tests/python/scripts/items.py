from common import *

h = hal.component("c")
h.newpin("p", FLOAT, OUT)
h.newparam("q", S32, RW)
h.ready()
for name in "p", "q":
    i = h.getitem(name)
    print(i, repr(i), str(i), i.get_name(), i.get_type(), i.get_dir(), i.is_pin(), i.get())
    i.set(3)
    print(i.get(), h[name])
print(type(h.getitem("p")).__name__, isinstance(h.getitem("p"), hal.item))
show("construct", lambda: hal.Pin("p"))
