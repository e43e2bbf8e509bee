"""Waveforms of a recording: values over time, comparison with a file, and pictures."""

import os
import pathlib

from . import picture

# Seconds in a unit of a VCD file.
_SCALES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "ps": 1e-12, "fs": 1e-15}


class Wave:
    """The changes of one value: times in seconds, and the values from then on."""

    def __init__(self, name, is_bit=False):
        self.name = name
        self.is_bit = is_bit
        self.times = []
        self.values = []

    def add(self, time, value):
        if self.times and self.times[-1] == time:
            self.values[-1] = value
        elif not self.values or self.values[-1] != value:
            self.times.append(time)
            self.values.append(value)

    def at(self, time):
        """Returns the value at a time in seconds."""
        value = None
        for changed, new in zip(self.times, self.values):
            if changed > time:
                break
            value = new
        return value

    @property
    def first(self):
        return self.values[0]

    @property
    def last(self):
        return self.values[-1]

    def edges(self):
        """Returns the times at which the value rises."""
        pairs = zip(self.times[1:], self.values, self.values[1:])
        return [time for time, before, after in pairs if before <= 0 < after]

    def __len__(self):
        return len(self.times)

    def __eq__(self, other):
        return isinstance(other, Wave) and (self.times, self.values) == (other.times, other.values)

    def __repr__(self):
        return "Wave(%r, %d changes)" % (self.name, len(self))


class Capture:
    """Waveforms by name. In a notebook it shows itself as a picture."""

    def __init__(self, file=None):
        self.waves = {}
        self.begin = 0.0
        self.end = 0.0
        if file is not None:
            self.read(file)

    def read(self, file):
        """Reads a VCD file, such as one of `record`."""
        by_code, scope, scale, time, begun = {}, [], 1e-9, 0.0, False
        words = iter(pathlib.Path(file).read_text(encoding="utf-8").split())
        for word in words:
            if word == "$timescale":
                text = "".join(iter(lambda: next(words), "$end"))
                digits = text.rstrip("abcdefghijklmnopqrstuvwxyz")
                scale = int(digits) * _SCALES[text[len(digits):]]
            elif word == "$scope":
                next(words)
                scope.append(next(words))
                next(words)
            elif word == "$upscope":
                scope.pop()
                next(words)
            elif word == "$var":
                kind, width, code, name = next(words), next(words), next(words), next(words)
                while next(words) != "$end":
                    pass
                name = ".".join(scope + [name])
                wave = Wave(name, kind == "wire" and width == "1")
                by_code[code] = (wave, kind)
                self.waves[name] = wave
            elif word in ("$comment", "$date", "$version"):
                while next(words) != "$end":
                    pass
            elif word[0] == "#":
                time = int(word[1:]) * scale
                if not begun:
                    begun, self.begin = True, time
                self.end = time
            elif word[0] in "01xzXZ":
                by_code[word[1:]][0].add(time, word[0] == "1")
            elif word[0] in "rR":
                by_code[next(words)][0].add(time, float(word[1:]))
            elif word[0] in "bB":
                wave, kind = by_code[next(words)]
                bits = word[1:]
                number = int(bits, 2) if set(bits) <= {"0", "1"} else 0
                if kind == "integer" and len(bits) >= 32 and bits[0] == "1":
                    number -= 1 << len(bits)
                wave.add(time, number)
        return self

    def __getitem__(self, name):
        if name not in self.waves:
            raise KeyError("%r was not recorded: there are %s" % (name, ", ".join(sorted(self.waves)) or "none"))
        return self.waves[name]

    def __iter__(self):
        return iter(self.waves.values())

    def __len__(self):
        return len(self.waves)

    def __eq__(self, other):
        return isinstance(other, Capture) and self.text() == other.text()

    def text(self):
        """Returns all changes as lines: the time in seconds, the name, the value."""
        rows = [(t, n, v) for n, w in self.waves.items() for t, v in zip(w.times, w.values)]
        rows.sort(key=lambda row: (row[0], row[1]))
        return "".join("%.9f %s %r\n" % (t - self.begin, n, v) for t, n, v in rows)

    def compare(self, file):
        """Compares the waveforms with those of a file of `text`. UPDATE_EXPECT=1 writes the file."""
        path, now = pathlib.Path(file), self.text()
        if os.environ.get("UPDATE_EXPECT") == "1":
            path.write_text(now, encoding="utf-8")
            return
        if not path.is_file():
            raise AssertionError("%s: there is no such file; UPDATE_EXPECT=1 writes it" % path)
        wanted = path.read_text(encoding="utf-8")
        if now == wanted:
            return
        ours, theirs = now.splitlines(), wanted.splitlines()
        for line in range(max(len(ours), len(theirs))):
            got = ours[line] if line < len(ours) else "(the end)"
            want = theirs[line] if line < len(theirs) else "(the end)"
            if got != want:
                raise AssertionError("%s:%d: expected %s, got %s" % (path, line + 1, want, got))

    def _repr_svg_(self):
        return picture.svg(self)
