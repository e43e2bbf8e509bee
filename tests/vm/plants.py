"""Faults put into what a good boot left: the comparison must find each of them."""

import dataclasses
import re

import judge

BEFORE_END = -1


def place(boot, name):
    """Returns the indices of the writes of a case."""
    marks = {v: int(k) for k, v in (line.split() for line in boot.files["marks"].decode().splitlines())}
    begin = boot.writes.index((judge.MARK, marks[name])) + 1
    end = next(i for i in range(begin, len(boot.writes)) if boot.writes[i][0] == judge.MARK)
    return begin, end


def data(boot, name, number):
    """Returns the index of a write to the data register, counted from the begin of a case or from its end."""
    begin, end = place(boot, name)
    return [i for i in range(begin, end) if boot.writes[i][0] == judge.DATA][number]


def written(boot, change):
    writes = list(boot.writes)
    change(writes)
    return dataclasses.replace(boot, writes=writes)


def filed(boot, name, pattern, text):
    found = boot.files[name].decode()
    changed = re.sub(pattern, text, found, count=1, flags=re.MULTILINE)
    if changed == found:
        raise ValueError(f"{name} has no {pattern}")
    return dataclasses.replace(boot, files={**boot.files, name: changed.encode()})


def lost(name, number):
    return lambda boot: written(boot, lambda writes: writes.pop(data(boot, name, number)))


def other(name, number, value):
    def change(boot):
        return written(boot, lambda writes: writes.__setitem__(data(boot, name, number), (judge.DATA, value)))

    return change


def added(name, number, write):
    return lambda boot: written(boot, lambda writes: writes.insert(place(boot, name)[number], write))


def left_running(name):
    """The last writes of a case are those before its outputs became safe."""

    def change(boot):
        begin, end = place(boot, name)
        safe = judge.SAFE.items()
        return dataclasses.replace(
            boot,
            writes=[w for i, w in enumerate(boot.writes) if not (begin <= i < end and w in safe)],
        )

    return change


PLANTS = {
    "an edge of a step is lost": lost("steps", 5000),
    "a value is written twice": added("steps", BEFORE_END, (judge.DATA, 0)),
    "a step goes to another line": other("steps", 5001, 0x10),
    "something writes to the control register": added("steps", BEFORE_END, (judge.CONTROL, 0x0C)),
    "a step of the printer is lost": lost("printer", 50),
    "a line of the printer stays on": added("printer", BEFORE_END, (judge.DATA, 0x02)),
    "something writes after the end": added("steps-done", BEFORE_END, (judge.DATA, 0)),
    "SIGTERM leaves the outputs on": left_running("SIGTERM"),
    "a crash leaves the outputs on": left_running("segv"),
    "a stuck function leaves the outputs on": left_running("spin"),
    "an end leaves another level": other("exit", -1, 0x0B),
    "a write behind the safe level": added("SIGINT", BEFORE_END, (judge.DATA, 0x01)),
    "the pump goes on after kill -9": added("kill-9-done", BEFORE_END, (judge.DATA, 0x05)),
    "the pump misses a beat": lost("kill-9", 10),
    "a refused user writes": added("user-not-in-lp", BEFORE_END, (judge.DATA, 0x01)),
    "another exit status": lambda boot: filed(boot, "status", "^SIGHUP 0$", "SIGHUP 1"),
    "a refusal names no command": lambda boot: filed(boot, "user-not-in-lp.log", "usermod", "something"),
    "a user has more rights": lambda boot: filed(boot, "user-ppdev.status", r"^(CapEff:\s*)0", r"\g<1>1"),
    "wake-ups are late": lambda boot: filed(boot, "wakeups.status", r"99.9 % within \d+", "99.9 % within 129"),
    "one wake-up is late": lambda boot: filed(boot, "wakeups.status", r"the latest [\d.]+", "the latest 1000.0"),
    "a page fault": lambda boot: filed(boot, "tasks.after", r"^(.*hal-thread\) (?:\S+ ){7})", r"\g<1>9"),
    "the thread is not under SCHED_FIFO": lambda boot: filed(
        boot, "tasks.after", r"^(.*hal-thread\) (?:\S+ ){38})1", r"\g<1>0"
    ),
    "memory is not locked": lambda boot: filed(boot, "memory", r"VmLck:\s+\d+", "VmLck: 0"),
    "a case failed in the guest": lambda boot: dataclasses.replace(boot, files={**boot.files, "errors": b"late\n"}),
    "the guest ends early": lambda boot: filed(boot, "marks", r"^(\d+) end$", r"\1 other"),
}


def all_found(boot, budget):
    """Prints whether the comparison finds each fault; returns how many it does not find."""
    missed = [what for what, plant in PLANTS.items() if not judge.Report(plant(boot), budget).bad]
    for what in missed:
        print(f"  FAILED this fault is not found: {what}")
    if not missed:
        print(f"  ok     planted faults: {len(PLANTS)} of {len(PLANTS)} are found")
    return len(missed)
