from common import *

class Panel(hal.component):
    kind = "panel"

    def __init__(self, name):
        hal.component.__init__(self, name)
        self.newpin("led", BIT, OUT)
        self.ready()

    def blink(self):
        self["led"] = not self["led"]
        return self.led

h = Panel("panel")
print(h.kind, h.blink(), h.blink(), h.getprefix())
show("own attribute", lambda: setattr(h, "other", 1))
h.__dict__["other"] = 5
print(h.other)
