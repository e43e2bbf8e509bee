from common import *
import _hal

print(_hal.error is hal.error, _hal.item is hal.item, _hal.connect is hal.connect)
print(issubclass(hal.component, _hal.component))
h = _hal.component("c")
h.newpin("a", FLOAT, OUT)
h.ready()
h["a"] = 2.5
print(h["a"], h.getprefix(), len(h), hal.get_value("c.a"))
show("attribute", lambda: h.getitem("a").get())
