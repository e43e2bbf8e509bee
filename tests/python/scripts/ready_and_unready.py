from common import *

h = hal.component("c")
show("unready", h.unready)
show("ready", h.ready)
show("ready", h.ready)
show("pin", lambda: h.newpin("a", BIT, OUT))
show("parameter", lambda: h.newparam("p", BIT, RO))
show("unready", h.unready)
show("is ready", lambda: hal.component_is_ready("c"))
show("pin", lambda: h.newpin("a", BIT, OUT).get_name())
show("ready", h.ready)
show("is ready", lambda: hal.component_is_ready("c"))
