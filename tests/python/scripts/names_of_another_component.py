from common import *

h = hal.component("c", "x")
g = hal.component("d", "x")
h.newpin("a", BIT, OUT)
show("same full name", lambda: g.newpin("a", BIT, OUT))
show("other", lambda: g.newpin("b", BIT, OUT).get_name())
