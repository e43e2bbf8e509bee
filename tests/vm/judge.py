"""Compares what the port's chip saw with what the guest recorded and with what the machines promise."""

import dataclasses
import io
import pathlib
import re
import resource
import subprocess
import tarfile
import zlib

HERE = pathlib.Path(__file__).resolve().parent

# Offsets from the port's address: two registers, and the address of the guest's marks, which has none.
DATA, CONTROL, MARK = 0, 2, 7
# What the kernel writes to the control register when a program claims a port.
CLAIMED = (CONTROL, 0x0C)

# The levels of ends.hal: safe, and while it runs, with the charge pump low and high.
SAFE = {DATA: 0x0A, CONTROL: 0x0B}
RUNNING = {DATA: (0x01, 0x05), CONTROL: (0x0E,)}
PUMP = 0x04

# Steps of each axis of steps.hal, with the bits of the data register of its signals.
STEPS = 10_000
LINES = {"x-step": 0, "x-dir": 1, "y-step": 2, "y-dir": 3}
PRINTER = {"xstep": 0, "xdir": 1}

# The cases of users: exit status, and what the message must name, or the capabilities of a process that runs.
RAWIO = 1 << 17
USERS = {
    "no-drivers": (1, ["sudo modprobe parport_pc", "sudo modprobe ppdev", "sudo usermod -aG lp"]),
    "no-node": (1, ["sudo modprobe ppdev"]),
    "not-in-lp": (1, ["sudo usermod -aG lp"]),
    "mode-x": (1, ["sudo setpriv --reuid", "--ambient-caps +sys_rawio halrun FILE"]),
    "privileged": (1, ["sudo chmod u-s", "sudo setcap -r"]),
    "ppdev": (0, 0),
    "instructions": (0, RAWIO),
    "mode-x-with": (0, RAWIO),
}

# The bar for wake-ups: a thread of 1 ms.
WITHIN_US, PERIOD_US = 128, 1000


def processor_time():
    """Returns the processor time of this program's children that have ended, in seconds."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@dataclasses.dataclass
class Boot:
    """What is left of a boot: the writes to the port, the guest's files, the time that it took."""

    writes: list
    files: dict
    time: str

    @classmethod
    def read(cls, out):
        trace = (out / "trace").read_text()
        writes = [(int(a, 16), int(v, 16)) for a, v in re.findall(r"addr 0x(\w+) val 0x(\w+)", trace)]
        return cls(writes, unpacked(out / "files.tar.gz"), (out / "time").read_text())


class Report:
    """The findings about one boot."""

    def __init__(self, boot, budget):
        self.files, self.lines, self.bad = boot.files, [], 0
        self.parts = parts(boot.writes, self.text("marks"))
        self.check("the guest came to its end", "end" in self.parts, self.text("kernel").strip() or boot.time.strip())
        if self.bad:
            return
        seconds, wall = boot.time.split()
        self.check(
            f"processor time is at most {budget} s", float(seconds) <= budget, f"{seconds} s, in {wall} s of wall clock"
        )
        self.check("no case failed in the guest", not self.text("errors"), self.text("errors").strip() or "none")
        self.statuses = dict(line.split() for line in self.text("status").splitlines())
        self.steps()
        self.printer()
        self.wakeups()
        self.users()
        self.ends()

    def text(self, name):
        return self.files.get(name, b"").decode(errors="replace")

    def check(self, what, good, figure):
        self.bad += not good
        self.lines.append(f"{'ok    ' if good else 'FAILED'} {what}: {figure}")

    def driver(self, name):
        """Returns the writes of a case behind those of the kernel, as it gives the port to the program."""
        writes = self.parts.get(name, [])
        claim = next((i for i, write in enumerate(writes) if write != CLAIMED), len(writes))
        return writes[claim:]

    def recorded(self, name, lines):
        """Every value on the wire is one that the guest recorded, and the other way round. Returns them."""
        writes = self.driver(name)
        data = [v for a, v in writes if a == DATA]
        # The machine's end writes the safe level twice: as the threads stop, and as the port is closed.
        recorded = [value for _, value in states(self.text(f"{name}.vcd"), lines)] + [0, 0]
        differs = next((i for i, (a, b) in enumerate(zip(data, recorded)) if a != b), min(len(data), len(recorded)))
        same = data == recorded and len(data) > 10
        figure = f"{len(data)} values" if same else f"{len(data)} and {len(recorded)}, the first that differs is {differs}"
        self.check(f"{name}: data register as recorded, value for value", same, figure)
        others = sorted({f"{a}:{v:#04x}" for a, v in writes if (a, v) != (CONTROL, 0x0B) and a != DATA})
        self.check(f"{name}: nothing else is written", not others and writes, " ".join(others) or "0 other writes")
        late = self.parts.get(f"{name}-done", [(DATA, 0)])
        self.check(f"{name}: nothing is written after the end", not late, f"{len(late)} writes")
        return data

    def printer(self):
        """X of the printer of the documents, in both directions."""
        data = self.recorded("printer", PRINTER)
        ways = [way for before, way in zip([None, *data], data) if before is None or (before ^ way) & 2]
        steps = [sum(1 for a, b in zip(data, data[1:]) if not a & 1 and b == 1 | way) for way in (0, 2)]
        good = [way & 2 for way in ways][:4] == [0, 2, 0, 2] and min(steps) > 50 and self.statuses.get("printer") == "0"
        self.check("printer: X to the right, to the left, and both again", good, f"{steps[0]} and {steps[1]} steps")

    def steps(self):
        data = self.recorded("steps", LINES)
        for axis in "xy":
            bit = 1 << LINES[f"{axis}-step"]
            rises = sum(1 for a, b in zip(data, data[1:]) if not a & bit and b & bit)
            self.check(f"steps: those of {axis} on the wire", rises == STEPS, rises)
        counts = self.text("steps.counts").split()
        self.check("steps: counts of the step generators", counts == [str(STEPS), str(-STEPS)], " ".join(counts))
        late = [line.split("  ")[-1].strip() for line in self.text("steps.status").splitlines() if "overruns" in line]
        self.lines.append(f"       overruns of the threads of 100 us and 1 ms: {'; '.join(late) or 'none'}")

    def wakeups(self):
        status = self.text("wakeups.status")
        found = re.search(r"half within (\d+) us, 99 % within (\d+) us, 99.9 % within (\d+) us, the latest ([\d.]+)", status)
        self.check(
            f"99.9 % of wake-ups within {WITHIN_US} us at 1 ms (emulated)",
            found is not None and int(found[3]) <= WITHIN_US,
            found[0] if found else "no figure",
        )
        on_time = found is not None and float(found[4]) < PERIOD_US and "overruns" not in status
        self.check("no wake-up is later than a period (emulated)", on_time, f"{found[4]} us" if found else "no figure")
        before, after = tasks(self.text("tasks.before")), tasks(self.text("tasks.after"))
        faults = sum(task["faults"] for task in after.values()) - sum(task["faults"] for task in before.values())
        self.check("no page fault in 10 s", before and before.keys() == after.keys() and not faults, faults)
        named = sorted((task["name"], task["policy"], task["priority"]) for task in after.values())
        fifo = {name: priority for name, policy, priority in named if policy == 1}
        self.check(
            "SCHED_FIFO for the thread and, above it, its watch",
            0 < fifo.get("hal-thread", 0) < fifo.get("hal-stuck", 0) and len(fifo) == 2,
            ", ".join(f"{name} {priority}" for name, priority in fifo.items()),
        )
        memory = re.search(r"([\d.]+) of ([\d.]+) MiB stay in RAM", status)
        locked = re.search(r"VmLck:\s+(\d+) kB", self.text("memory"))
        self.check(
            "memory is locked",
            memory and memory[1] == memory[2] and locked and int(locked[1]) > 0,
            f"{memory[0] if memory else 'no figure'}, VmLck {locked[1] if locked else '?'} kB",
        )

    def users(self):
        for name, (status, expected) in USERS.items():
            log, what = self.text(f"user-{name}.log"), f"user, {name}"
            writes = self.driver(f"user-{name}") + self.parts.get(f"user-{name}-done", [])
            got = self.statuses.get(f"user-{name}")
            if status:
                named = [command for command in expected if command in log]
                good = got == str(status) and named == expected and not writes
                self.check(what, good, f"refused, {len(writes)} writes; says {log.strip()!r}")
                continue
            data = [v for a, v in writes if a == DATA]
            runs = re.search(r"CapEff:\s*(\w+)", self.text(f"user-{name}.status"))
            # A square wave, and the safe level twice at the end.
            is_wave = len(data) > 10 and all(a != b for a, b in zip(data[:-3], data[1:-2])) and data[-2:] == [0, 0]
            good = got == "0" and is_wave and runs is not None and int(runs[1], 16) == expected
            caps = runs[1].lstrip("0") or "none" if runs else log.strip()
            self.check(what, good, f"{len(data)} values, the last {data[-1:]}, capabilities {caps}, status {got}")

    def ends(self):
        """The last write of each way to end is the level that it promises, and nothing comes after it."""
        rows = [line.split() for line in (HERE / "ends.table").read_text().splitlines() if not line.startswith("#")]
        for way, _, _, by, outputs, status in rows:
            alive = self.driver(way)
            later = [write for part in ("-fault", "-stopped") for write in self.parts.get(way + part, [])]
            # A fault makes the outputs safe before anybody ends the process.
            judged = alive if by.startswith("fault") else alive + later
            last = {r: next((v for a, v in reversed(judged) if a == r), None) for r in (DATA, CONTROL)}
            ran = all(any((r, v) in alive for v in RUNNING[r]) for r in (DATA, CONTROL))
            safe = last == SAFE and all(v == SAFE[r] for r, v in later)
            as_is = all(last[r] in RUNNING[r] for r in last)
            pump = [v & PUMP for a, v in alive if a == DATA and v != SAFE[DATA]]
            pumped = len(pump) > 1 and all(a != b for a, b in zip(pump, pump[1:]))
            silent = not self.parts.get(f"{way}-done", [(DATA, 0)])
            ends = self.statuses.get(way) == status
            good = ran and pumped and silent and ends and (safe if outputs == "safe" else as_is)
            level = f"last data {last[DATA]:#04x}, control {last[CONTROL]:#04x}" if None not in last.values() else "no write"
            pump = f"pump {len(pump)} edges, then still"
            self.check(
                f"end by {way} ({outputs})",
                good,
                f"{level}; {pump if pumped and silent else 'the pump is wrong'}; status {self.statuses.get(way)}",
            )


def picture(boot, out, halscope):
    """Draws the printer's lines twice, as the guest recorded them and as the chip saw them. The wire has the order of its
    values and no times of the guest: each has that of its change."""
    name, files = out / "printer.vcd", boot.files
    recorded = states(files.get("printer.vcd", b"").decode(), PRINTER)
    parted = parts(boot.writes, files.get("marks", b"").decode())
    seen = [v for a, v in parted.get("printer", []) if a == DATA]
    if not recorded or len(seen) < len(recorded):
        return
    signals = [(f"{where}-{line}", bit) for where in ("recorded", "wire") for line, bit in PRINTER.items()]
    lines = ["$timescale 1 ns $end", *(f"$var wire 1 {chr(33 + i)} {s} $end" for i, (s, _) in enumerate(signals))]
    lines.append("$enddefinitions $end")
    for (time, state), value in zip(recorded, seen):
        lines.append(f"#{time}")
        values = [state, state, value, value]
        lines += [f"{v >> bit & 1}{chr(33 + i)}" for i, (v, (_, bit)) in enumerate(zip(values, signals))]
    name.write_text("\n".join(lines) + "\n")
    if halscope.exists():
        title = "X of the printer, as it was recorded and as it was on the wire"
        subprocess.run([halscope, "plot", "-o", out / "printer.svg", "--title", title, name], check=True)


def same(kind, boots):
    """Prints whether all boots wrote the same; returns the number of faults."""
    first, *_ = traces = [boot.writes for boot in boots]
    for number, trace in enumerate(traces[1:], 2):
        if trace == first and first:
            continue
        at = next((i for i, (a, b) in enumerate(zip(first, trace)) if a != b), min(len(first), len(trace)))
        print(f"  FAILED boots 1 and {number} of {kind} write the same: write {at} of {len(first)} and {len(trace)} differs")
        return 1
    print(f"  ok     {len(traces)} boots of {kind} write the same: {len(first)} writes, crc {crc(first):08x}")
    return 0


def crc(writes):
    return zlib.crc32(bytes(byte for write in writes for byte in write))


def unpacked(archive):
    """Returns the guest's files by name; those that arrived, if the archive is cut."""
    files = {}
    try:
        with tarfile.open(fileobj=io.BytesIO(archive.read_bytes()), mode="r:gz") as tar:
            for member in tar:
                if member.isfile():
                    files[pathlib.PurePath(member.name).name] = tar.extractfile(member).read()
    except (tarfile.TarError, EOFError, OSError, zlib.error):
        pass
    return files


def parts(writes, marks):
    """Divides the writes at the guest's marks."""
    names = {int(number): name for number, name in (line.split() for line in marks.splitlines())}
    found, name = {}, "boot"
    for address, value in writes:
        # The kernel's probe does not write there.
        if address == MARK:
            name = names.get(value, f"mark {value}")
        else:
            found.setdefault(name, []).append((address, value))
        found.setdefault(name, [])
    return found


def states(vcd, lines):
    """Returns the values of the data register that a recording of its lines implies, with the time of each change."""
    bits, out, values = {}, [], dict.fromkeys(lines.values(), 0)
    head, _, body = vcd.partition("$enddefinitions $end")
    for code, name in re.findall(r"\$var wire 1 (\S+) (\S+) \$end", head):
        bits[code] = lines[name]
    if set(bits.values()) != set(lines.values()):
        return []
    _, *moments = re.split(r"^#(\d+)$", body, flags=re.MULTILINE)
    for time, moment in zip(moments[::2], moments[1::2]):
        for value, code in re.findall(r"^([01])(\S+)$", moment, flags=re.MULTILINE):
            values[bits[code]] = int(value)
        state = sum(value << bit for bit, value in values.items())
        if not out or out[-1][1] != state:
            out.append((int(time), state))
    return out


def tasks(text):
    """Returns the threads of a process by their numbers, from lines of /proc/PID/task/*/stat."""
    found = {}
    for line in text.splitlines():
        number, _, rest = line.partition(" (")
        name, _, rest = rest.rpartition(") ")
        fields = rest.split()
        # Fields 10 and 12 are the minor and major page faults, 40 and 41 the priority and the policy.
        found[number] = {
            "name": name,
            "faults": int(fields[7]) + int(fields[9]),
            "priority": int(fields[37]),
            "policy": int(fields[38]),
        }
    return found
