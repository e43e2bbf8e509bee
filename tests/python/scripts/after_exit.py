from common import *

h = hal.component("c")
p = h.newpin("a", BIT, OUT)
h.ready()
show("exit", h.exit)
show("item", lambda: h["a"])
show("set item", lambda: h.__setitem__("a", 1))
show("attribute", lambda: h.a)
show("pin", lambda: h.newpin("b", BIT, OUT))
show("parameter", lambda: h.newparam("b", BIT, RO))
