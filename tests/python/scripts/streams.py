#: loadrt sampler depth=8 cfg=bfsu
from common import *

h = hal.component("c")
h.ready()
st = hal.stream(h, hal.sampler_base)
print(st.element_types, st.readable, st.read(), st.num_underruns)
show("bad key", lambda: hal.stream(h, 99))
show("no key", lambda: hal.stream(h))
