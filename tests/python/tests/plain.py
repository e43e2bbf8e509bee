"""A machine without pytest: values, waveforms, refusals, a picture."""

import sys

from ferrule import Machine, Refused

with Machine("machine.hal") as machine:
    print(machine.siggen_0_frequency, machine["sum"], machine.and2_0_out)
    with machine.record("wave", "and2.0.in*", "and2.0.out", "sum") as capture:
        machine.and2_0_in0 = True
        machine.run("100ms")
        machine.sum = 2.5
        machine.and2_0_in1 = True
        machine.run(0.9)
    print(sorted(capture.waves))
    print(capture["and2.0.out"].edges(), capture["sum"].at(0.05), capture["sum"].last)
    print(capture["wave"].edges(), "%.3f" % max(capture["wave"].values))
    picture = capture._repr_svg_()
    print(picture.startswith("<svg"), picture.count("<path"), "and2.0.out" in picture)
    for wrong in (lambda: machine.nothing, lambda: machine["nothing"], lambda: setattr(machine, "and2_0_in0", 3.5),
                  lambda: machine.run("3 weeks"), lambda: capture["nothing"], lambda: capture.compare("none.txt"),
                  lambda: machine.command("task.nothing"), lambda: machine.a_b, lambda: setattr(machine, "run", 1)):
        try:
            wrong()
        except (AttributeError, Refused, ValueError, KeyError, AssertionError) as why:
            print(type(why).__name__, str(why).split(";")[0])
for text in (None, "loadrt nothing_here\n"):
    if text:
        with open("bad.hal", "w") as file:
            file.write(text)
    try:
        Machine("bad.hal")
    except (FileNotFoundError, Refused) as why:
        print(type(why).__name__, str(why).splitlines()[0].rpartition("/bad.hal")[2].split(" (")[0])
