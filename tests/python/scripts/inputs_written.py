from common import *

h = hal.component("c")
i = h.newpin("in", FLOAT, IN)
h.ready()
show("set", lambda: i.set(4))
show("get", i.get)
show("value", lambda: hal.get_value("c.in"))
