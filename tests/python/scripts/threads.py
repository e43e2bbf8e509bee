from common import *
import threading

h = hal.component("c")
for n in range(4):
    h.newpin(f"p{n}", S32, OUT)
h.ready()

def count(n):
    for i in range(1000):
        h[f"p{n}"] = i + n

all = [threading.Thread(target=count, args=(n,)) for n in range(4)]
for t in all:
    t.start()
for t in all:
    t.join()
print([h[f"p{n}"] for n in range(4)], hal.get_value("c.p3"))
