"""Facts of a machine from its files: the INI file and the tool table."""

import os
from collections import namedtuple

import _machine

LETTERS = "XYZABCUVW"
NO_LIMIT = 1e99
MM_PER_INCH = 25.4

tool = namedtuple(
    "tool_result",
    "id xoffset yoffset zoffset aoffset boffset coffset uoffset voffset woffset "
    "diameter frontangle backangle orientation",
)
NO_TOOL = tool(-1, *(0.0,) * 12, 0)
tool.__module__ = "linuxcnc"

#: Units per degree.
ANGULAR_UNITS = {
    "deg": 1.0, "degree": 1.0, "grad": 0.9, "gon": 0.9, "rad": 0.017453292519943295, "radian": 0.017453292519943295,
}


def ini_file(channel):
    """Returns the path of the machine's INI file, or an empty text."""
    path = os.environ.get("INI_FILE_NAME", "")
    if path:
        return os.path.abspath(path)
    pid, args = channel.loaded("task")
    for word in (args or "").split():
        if word.startswith("ini="):
            try:
                return os.path.join(os.readlink("/proc/%d/cwd" % pid), word[4:])
            except OSError:
                return ""
    return ""


class Facts:
    """Entries of the INI file, and the tool table."""

    def __init__(self, path):
        self.path = path
        self.ini = _machine.ini(path) if path else None
        number, word = self.number, self.word
        self.linear_units = 1 / MM_PER_INCH if self.ini and _machine.is_inch(self.ini) else 1.0
        self.angular_units = ANGULAR_UNITS.get(word("TRAJ", "ANGULAR_UNITS", "deg").lower(), 1.0)
        letters = word("TRAJ", "COORDINATES", "XYZ").upper().replace(" ", "")
        self.coordinates = [LETTERS.index(c) for c in letters if c in LETTERS]
        self.axis_mask = sum({1 << n for n in self.coordinates})
        self.cycle_time = number("TASK", "CYCLE_TIME", 0.001)
        self.debug = int(word("EMC", "DEBUG", "0"), 0)
        self.spindles = int(number("TRAJ", "SPINDLES", 1))
        self.max_acceleration = number("TRAJ", "MAX_LINEAR_ACCELERATION", NO_LIMIT)
        self.acceleration = number("TRAJ", "DEFAULT_LINEAR_ACCELERATION", self.max_acceleration)
        words = word("KINS", "KINEMATICS", "trivkins").split()
        both = any(w.lower() == "kinstype=both" for w in words)
        self.kinematics_type = 1 if words[:1] == ["trivkins"] and not both else 4
        self.random = word("EMCIO", "RANDOM_TOOLCHANGER", "0") == "1"
        self.joints = [self.joint(n) for n in range(16)]
        self.axes = [self.axis(letter) for letter in LETTERS]
        table = word("EMCIO", "TOOL_TABLE", "")
        self.table = os.path.join(os.path.dirname(path), table) if table else None
        self._tools = (None, [])

    def word(self, section, name, default):
        value = self.ini.find(section, name) if self.ini else None
        return default if value is None or not value.strip() else value.strip()

    def number(self, section, name, default):
        try:
            return float(self.word(section, name, default))
        except ValueError:
            return default

    def joint(self, n):
        """Returns the facts of a joint."""
        section = "JOINT_%d" % n
        angular = self.word(section, "TYPE", "LINEAR").upper() == "ANGULAR"
        minimum = self.number(section, "MIN_FERROR", 1.0)
        return {
            "jointType": 2 if angular else 1,
            "units": self.angular_units if angular else self.linear_units,
            "backlash": self.number(section, "BACKLASH", 0.0),
            "min_position_limit": self.number(section, "MIN_LIMIT", -NO_LIMIT),
            "max_position_limit": self.number(section, "MAX_LIMIT", NO_LIMIT),
            "max_ferror": self.number(section, "FERROR", minimum),
            "min_ferror": minimum,
        }

    def axis(self, letter):
        """Returns the limits of an axis."""
        section = "AXIS_" + letter
        if not self.axis_mask >> LETTERS.index(letter) & 1:
            return {"min_position_limit": 0.0, "max_position_limit": 0.0}
        return {
            "min_position_limit": self.number(section, "MIN_LIMIT", -NO_LIMIT),
            "max_position_limit": self.number(section, "MAX_LIMIT", NO_LIMIT),
        }

    def tools(self):
        """Returns the rows of the tool table: number, pocket, nine offsets, diameter, angles, orientation."""
        if self.table is None:
            return []
        try:
            found = os.stat(self.table)
        except OSError:
            return []
        version = (found.st_mtime_ns, found.st_size, found.st_ino)
        if self._tools[0] != version:
            self._tools = (version, _machine.tools(self.table))
        return self._tools[1]

    def tool_table(self, in_spindle):
        """Returns the tools, that in the spindle first."""
        rows = [tool(number, *offsets, diameter, front, back, orientation)
                for number, _, offsets, diameter, front, back, orientation in self.tools()]
        first = next((row for row in rows if row.id == in_spindle), NO_TOOL)
        return (first, *rows)
