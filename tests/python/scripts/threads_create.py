from common import *
import threading

h = hal.component("c")
h.newpin("shared", S32, OUT)
reads = []

def create(n):
    for i in range(100):
        h.newpin(f"t{n}-{i}", S32, OUT)
        h[f"t{n}-{i}"] = n * 1000 + i

def read():
    for i in range(2000):
        h["shared"] = i
        reads.append(h["shared"] == i and len(h) > 0 and h.getprefix() == "c")

workers = [threading.Thread(target=create, args=(n,)) for n in range(3)]
workers.append(threading.Thread(target=read))
for t in workers:
    t.start()
for t in workers:
    t.join()
h.ready()
print(len(h), len(reads), set(reads))
print(sum(h[f"t{n}-{i}"] == n * 1000 + i for n in range(3) for i in range(100)))
settle()
print(sum(hal.get_value(f"c.t{n}-{i}") == n * 1000 + i for n in range(3) for i in range(100)))
