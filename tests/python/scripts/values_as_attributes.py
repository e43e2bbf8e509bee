from common import *

h = hal.component("c")
for name, ty in ("b", BIT), ("f", FLOAT), ("s", S32), ("u", U32):
    h.newpin(name, ty, IO)
h.ready()
for name in "bfsu":
    for v in (3, -3, 2.75, "7", None, 2**32):
        show(f"{name}={v}", lambda: setattr(h, name, v))
        show("  attribute", lambda: getattr(h, name))
