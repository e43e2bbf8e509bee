from common import *

h = hal.component("c")
h.newpin("a", BIT, OUT)
show("pin", lambda: h.newpin("a", BIT, OUT))
show("pin of another type", lambda: h.newpin("a", FLOAT, IN))
show("parameter", lambda: h.newparam("a", BIT, RO))
h.newparam("p", BIT, RO)
show("pin of a parameter's name", lambda: h.newpin("p", BIT, OUT))
print(len(h))
