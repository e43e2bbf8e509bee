"""An instance on the virtual clock, in a process of its own, and its pins."""

import json
import os
import pathlib
import re
import shutil
import socket
import subprocess
import tempfile

from .capture import Capture

# Nanoseconds in a unit of time.
_UNITS = {"ns": 1, "us": 1_000, "ms": 1_000_000, "s": 1_000_000_000, "min": 60_000_000_000, "h": 3_600_000_000_000}
_LISTS = ("pins", "params", "signals")
# Longest wait for an answer or for the begin of the instance, in seconds of the wall clock.
PATIENCE = 120.0


class Refused(Exception):
    """A request that the machine has refused."""


def nanoseconds(time):
    """Returns a time in nanoseconds: a number of seconds, or a text such as "20ms", "2 s" or "1.5min"."""
    if isinstance(time, (int, float)):
        number, unit = float(time), "s"
    else:
        found = re.fullmatch(r"\s*([0-9.]+)\s*([a-z]+)\s*", str(time))
        if not found or found[2] not in _UNITS:
            raise ValueError("%r is no time: use seconds, or a text such as '20ms' (%s)" % (time, ", ".join(_UNITS)))
        number, unit = float(found[1]), found[2]
    whole = round(number * _UNITS[unit])
    if whole < 0:
        raise ValueError("%r is no time: it is below 0" % (time,))
    return whole


def _halrun():
    """Returns the program halrun: beside the folder of this package, or on the path."""
    beside = pathlib.Path(__file__).resolve().parents[2] / "halrun"
    found = os.environ.get("FERRULE_HALRUN") or (str(beside) if beside.is_file() else shutil.which("halrun"))
    if not found:
        raise FileNotFoundError("halrun is not on the path: install Ferrule, or name it in FERRULE_HALRUN")
    return found


def _value(tagged):
    """Returns a value of the protocol as one of Python."""
    (kind, value), = tagged.items()
    if kind == "bit":
        return bool(value)
    return float(value) if kind == "float" else int(value)


def _text(value):
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return repr(float(value)) if isinstance(value, float) else str(value)


class Machine:
    """An instance that runs a HAL or INI file on the virtual clock, with a thread. Its time moves in run() alone.

    Pins, parameters and signals are items (machine["and2.0.out"]) and attributes, with _ for any of - and .
    (machine.and2_0_out)."""

    def __init__(self, file, *words, simulate=True):
        self._folder = tempfile.TemporaryDirectory(prefix="ferrule-")
        self._names = {}
        try:
            self._start(pathlib.Path(file), words, simulate)
        except BaseException:
            self.close()
            raise

    def _start(self, file, words, simulate):
        if not file.is_file():
            raise FileNotFoundError("%s: there is no such file" % file)
        whole = file.resolve()
        command = [_halrun(), "--virtual", "--hold", "--detach", "--instance", "test"]
        command += ["--simulate"] if simulate else []
        self._environment = dict(os.environ, HAL_RUNTIME_DIR=self._folder.name, HAL_HEADLESS="1")
        # It goes on in the background once the file is carried out.
        begun = subprocess.run([*command, *words, str(whole)], env=self._environment, cwd=whole.parent,
                               stdin=subprocess.DEVNULL, capture_output=True, timeout=PATIENCE)
        if begun.returncode != 0:
            raise Refused((begun.stderr + begun.stdout).decode(errors="replace").strip())
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(PATIENCE)
        try:
            self._socket.connect(os.path.join(self._folder.name, "ferrule", "test.sock"))
        except OSError:
            raise Refused("the machine has ended; without a thread it does not stay up: " + self.said()) from None
        self._lines = self._socket.makefile("r", encoding="utf-8")
        self.ask({"hello": {"protocol": 1, "name": "", "pid": os.getpid()}})
        self.refresh()

    def said(self):
        """Returns what the instance has written since the file was carried out."""
        log = pathlib.Path(self._folder.name, "ferrule", "test.log")
        return log.read_text(errors="replace").strip() if log.is_file() else ""

    def ask(self, request):
        """Sends a request of the protocol and returns its answer."""
        try:
            self._socket.sendall(json.dumps({"request": request}).encode() + b"\n")
            line = self._lines.readline()
        except OSError:
            line = ""
        if not line:
            raise Refused("the machine has ended: " + self.said())
        answer = json.loads(line)
        if "error" in answer:
            failure = answer["error"]
            raise Refused(failure["text"] + ("; " + failure["hint"] if failure.get("hint") else ""))
        return answer["ok"]

    def refresh(self):
        """Reads the names of pins, parameters and signals again, such as after a load."""
        names = {}
        for kind in _LISTS:
            answer = self.ask({"list": {"kind": kind, "patterns": [], "ty": None}})
            for item in next(iter(answer.values())):
                names.setdefault(item["name"], kind)
        self.__dict__["_names"] = names
        plain = {}
        for name in names:
            # A name that two have, or that a method has, must be written as machine["name"].
            word = re.sub(r"[-.]", "_", name)
            plain[word] = None if word in plain or hasattr(type(self), word) else name
        self.__dict__["_plain"] = plain

    def names(self):
        """Returns the names of all pins, parameters and signals."""
        return sorted(self._names)

    def __getitem__(self, name):
        kind = "get-signal" if self._names.get(name) == "signals" else "get"
        return _value(self.ask({kind: {"name": name}})["value"])

    def __setitem__(self, name, value):
        kind = "set-signal" if self._names.get(name) == "signals" else "set"
        self.ask({kind: {"name": name, "value": _text(value)}})

    def __getattr__(self, plain):
        return self[self._named(plain)]

    def __setattr__(self, plain, value):
        if plain.startswith("_") and plain not in self.__dict__.get("_plain", {}):
            self.__dict__[plain] = value
        else:
            self[self._named(plain)] = value

    def _named(self, plain):
        """Returns the name of the pin, parameter or signal that an attribute means."""
        names = self.__dict__.get("_plain", {})
        if plain not in names:
            raise AttributeError("the machine has no pin, parameter or signal '%s'" % plain)
        if names[plain] is None:
            raise AttributeError("'%s' is a method, or the name of several: write machine[\"NAME\"]" % plain)
        return names[plain]

    def run(self, time):
        """Lets machine time pass: a number of seconds, or a text such as "20ms"."""
        self.ask({"run": {"ns": nanoseconds(time)}})

    def command(self, name, **arguments):
        """Gives a command, such as command("task.mdi", text="G0 X1"), waits for its end, and returns what it says."""
        words = ["%s=%s" % (key, _text(value)) for key, value in arguments.items()]
        answer = self.ask({"command": {"name": name, "args": words}})["answer"]
        if answer.get("ticket"):
            self.wait(answer["ticket"])
        return answer.get("text", "")

    def wait(self, ticket, step="10ms", limit="1h"):
        """Lets machine time pass until a command has ended."""
        left = nanoseconds(limit)
        while left > 0:
            state = self.ask({"ticket": {"id": ticket, "wait": False}})["ticket"]["state"]
            if state == "done":
                return
            if state != "pending":
                raise Refused(str(next(iter(state.values()))) if isinstance(state, dict) else state)
            self.run(step)
            left -= nanoseconds(step)
        raise Refused("the command did not end within %s of machine time" % limit)

    def record(self, *patterns):
        """Records pins and signals that match: `with machine.record("x*") as capture: machine.run("1s")`."""
        return _Recording(self, patterns)

    def close(self):
        """Ends the instance."""
        if "_environment" in self.__dict__:
            if "_lines" in self.__dict__:
                self._lines.close()
                self._socket.close()
            # It waits until the instance has ended.
            subprocess.run([_halrun(), "-U", "--instance", "test"], env=self.__dict__.pop("_environment"),
                           stdin=subprocess.DEVNULL, capture_output=True, timeout=PATIENCE)
        self._folder.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class _Recording:
    """A recording in progress; its capture is whole at the end."""

    def __init__(self, machine, patterns):
        self._machine = machine
        self._patterns = list(patterns)
        self._path = os.path.join(machine._folder.name, "capture.vcd")

    def __enter__(self):
        self._machine.ask({"record": {"path": self._path, "patterns": self._patterns}})
        self._capture = Capture()
        return self._capture

    def __exit__(self, *_):
        self._machine.ask("end-record")
        self._capture.read(self._path)
