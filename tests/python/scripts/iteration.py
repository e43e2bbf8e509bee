from common import *

h = hal.component("c")
h.newpin("a", BIT, OUT)
show("iterate", lambda: list(h))
show("contains", lambda: "a" in h)
show("call", lambda: h())
show("repr", lambda: repr(h).split("(")[0])
show("count", lambda: repr(h).split(") ")[1])
