import subprocess
import sys
from common import *

h = hal.component("c")
h.ready()
s = hal.stream(h, 77, 4, "bfsu")
print(s, s.element_types, s.depth, s.maxdepth, s.readable, s.writable, s.num_overruns, s.num_underruns)
print(s.read())
for record in ((True, 1.5, -3, 4), (False, 2.5, -4, 5), (True, 3.0, 5, 6)):
    show("write", lambda: s.write(record))
show("full", lambda: s.write((True, 0.0, 0, 0)))
print(s.depth, s.readable, s.writable, s.num_overruns)
other = """
import hal
h = hal.component("d")
h.ready()
s = hal.stream(h, 77, "bfsu")
print(s.element_types, s.maxdepth)
print(s.read(), s.sampleno, s.read(), s.sampleno)
s.write((False, 4.5, -7, 8))
try:
    hal.stream(h, 78, "b")
except OSError as why:
    print("OSError", why.errno)
"""
print(subprocess.run([sys.executable, "-c", other], capture_output=True, text=True).stdout, end="")
print(s.read(), s.read(), s.read())
for name, depth, types in (("depth", 0, "b"), ("bits", 3, "b" * 21)):
    show(name, lambda: hal.stream(h, 79, depth, types).element_types)
show("list", lambda: s.write([1, 2, 3, 4]))
show("bits", lambda: s.write(("x", 1.0, 2, 3)))
show("text", lambda: s.write((True, "x", 2, 3)))
