from common import *

h = hal.component("c")
p = h.newpin("x", BIT, OUT)
h.ready()
for v in (0, 1, -1, 1.5, -1.5, True, False, "1", " 2 ", b"3", "x", "", None, [], 2**31 - 1, 2**31, -2**31, -2**31 - 1, 2**32 - 1, 2**32, 2**63, 2**64, -2**63 - 1, float("inf"), float("-inf"), float("nan"), 10**400):
    show(str(v)[:30], lambda: p.set(v))
    show("  get", p.get)
