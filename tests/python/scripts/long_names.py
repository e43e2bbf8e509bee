from common import *

h = hal.component("c")
show("40", lambda: h.newpin("n" * 40, BIT, OUT).get_name())
show("200", lambda: type(h.newpin("n" * 200, BIT, OUT)))
show("parameter", lambda: type(h.newparam("n" * 200, BIT, RO)))
show("signal", lambda: hal.new_sig("n" * 200, BIT))
print(len(h))
