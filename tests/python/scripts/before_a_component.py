from common import *

for name in "component_exists", "component_is_ready", "get_value", "pin_has_writer", "disconnect":
    show(name, lambda: getattr(hal, name)("x"))
for name in "get_info_pins", "get_info_params", "get_info_signals":
    show(name, getattr(hal, name))
show("connect", lambda: hal.connect("a", "b"))
show("new_sig", lambda: hal.new_sig("a", BIT))
show("set_p", lambda: hal.set_p("a", "1"))
