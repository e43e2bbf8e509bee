from common import *

h = hal.component("c")
h.newpin("a", S32, OUT)
h.ready()
h["a"] = 5
h.exit()
g = hal.component("c")
show("pins", lambda: hal.get_info_pins())
show("pin", lambda: g.newpin("a", S32, OUT).get())
g.ready()
show("ready", lambda: hal.component_is_ready("c"))
