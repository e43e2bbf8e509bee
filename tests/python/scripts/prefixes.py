from common import *

h = hal.component("c", "p")
print(h.getprefix())
h.newpin("a", BIT, OUT)
h.setprefix("q")
print(h.getprefix())
h.newpin("b", BIT, OUT)
h.ready()
print([p["NAME"] for p in hal.get_info_pins()])
print(h["a"], h["b"])
