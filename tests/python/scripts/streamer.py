#: loadrt streamer depth=8 cfg=bfsu
from common import *

h = hal.component("c")
h.ready()
st = hal.stream(h, hal.streamer_base)
print(st.element_types, st.maxdepth, st.depth, st.writable, st.readable)
for n in range(9):
    show(f"write {n}", lambda: st.write((n % 2, n / 2, -n, n)))
print(st.depth, st.writable, st.num_overruns)
for record in (), (1, 2.0), None, [1, 2.0, 3, 4], (1, "x", 3, 4), (1, 2.0, 2**40, 4):
    try:
        st.write(record)
    except Exception as e:
        print(type(e).__name__)
