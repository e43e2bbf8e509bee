from common import *

show("before", lambda: hal.component_exists("c"))
h = hal.component("c")
show("exists", lambda: hal.component_exists("c"))
show("ready", lambda: hal.component_is_ready("c"))
h.ready()
show("ready", lambda: hal.component_is_ready("c"))
show("other", lambda: hal.component_exists("d"))
show("other", lambda: hal.component_is_ready("d"))
show("again", lambda: hal.component("c"))
show("too long", lambda: hal.component("x" * 60))
show("no name", lambda: hal.component())
show("a number", lambda: hal.component(3))
