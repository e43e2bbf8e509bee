from common import *

h = hal.component("c")
h.newpin("a", BIT, OUT)
h.ready()
show("item", lambda: h["b"])
show("set item", lambda: h.__setitem__("b", 1))
show("attribute", lambda: h.b)
show("set attribute", lambda: setattr(h, "b", 1))
show("getitem", lambda: h.getitem("b"))
show("number", lambda: h[3])
show("none", lambda: h[None])
