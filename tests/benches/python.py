"""Prints the time of one access to a pin from Python, in nanoseconds: the least of 400 rounds of 5000, with the loop around it."""

import timeit

import hal

h = hal.component("bench")
pin = h.newpin("out", hal.HAL_FLOAT, hal.HAL_OUT)
h.ready()
for code in ["pass", "pin.get()", "pin.set(1.5)", "h['out']", "h['out'] = 1.5", "h.out"]:
    rounds = timeit.repeat(code, globals={"h": h, "pin": pin}, number=5000, repeat=400)
    print("%-16s %6.1f" % (code, min(rounds) / 5000 * 1e9))
h.exit()
