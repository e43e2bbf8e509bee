"""The interpreter as functions of remaps and O-words see it.

The state is a copy: what is set goes back to the interpreter with the next step of the function."""

import enum

import _ferrule_remap as _host

throw_exceptions = 1
TOLERANCE_EQUAL = 0.0001


def _enum(name, **members):
    made = enum.IntEnum(name, members)
    globals()[name] = made
    globals().update(made.__members__)
    return made


_enum("InterpReturn", INTERP_OK=0, INTERP_EXIT=1, INTERP_EXECUTE_FINISH=2, INTERP_ENDFILE=3,
      INTERP_FILE_NOT_OPEN=4, INTERP_ERROR=5)
INTERP_MIN_ERROR = 3
_enum("FEED_MODE", UNITS_PER_MINUTE=0, INVERSE_TIME=1, UNITS_PER_REVOLUTION=2)
_enum("DISTANCE_MODE", MODE_ABSOLUTE=0, MODE_INCREMENTAL=1)
_enum("RETRACT_MODE", R_PLANE=0, OLD_Z=1)
_enum("SPINDLE_MODE", CONSTANT_RPM=0, CONSTANT_SURFACE=1)
_enum("CUTTER_COMP_DIRECTION", RIGHT=1, LEFT=2)

_LETTERS = "abcdefhijklpqrstuvwxyz"
_INTEGER_WORDS = {"h": -1, "l": -1, "t": 0}
_INTEGER_FIELDS = {
    "task", "current_tool", "current_pocket", "selected_tool", "selected_pocket", "motion_mode", "plane",
    "length_units", "distance_mode", "ijk_distance_mode", "retract_mode", "cutter_comp_orientation",
    "origin_index", "value_returned", "call_level", "sequence_number", "num_spindles",
    "random_toolchanger", "cutter_comp_side", "feed_mode"}
_FLAGS = {"feed_override", "mist", "flood"}
# Fields that a function may set.
_WRITABLE = {"feed_rate", "return_value", "value_returned", "selected_tool", "current_tool", "motion_mode",
             "distance_mode", "ijk_distance_mode", "retract_mode", "feed_mode", "plane"}
# Fields that follow from others: the function's own value holds until its next step.
_DERIVED = {"current_pocket", "selected_pocket"}
# Fields that other interpreters use to tell themselves that something has happened.
_SIGNS = {"toolchange_flag": False, "tool_change_flag": False, "probe_flag": False, "input_flag": False,
          "input_index": -1, "input_digital": False}
_CONSTANT = {"debugmask": 0, "loggingLevel": 0, "linetext": "", "active_spindle": 0, "percent_flag": False,
             "mdi_interrupt": False, "tool_change_at_g30": 0, "tool_change_quill_up": 0,
             "tool_change_with_spindle_on": 0}


class InterpreterException(Exception):
    """An error of a line that a function has executed."""

    def __init__(self, error_message="", line_number=0, line_text=""):
        super().__init__(error_message)
        self.error_message = error_message
        self.line_number = line_number
        self.line_text = line_text


def equal(a, b):
    return abs(a - b) < TOLERANCE_EQUAL


def is_near_int(value):
    return abs(value - round(value)) < TOLERANCE_EQUAL


def nearest_int(value):
    return int(round(value))


class Remap:
    """A remapped code, as its REMAP entry describes it."""

    def __init__(self, view):
        hooks = dict(view["hooks"])
        self.name = view["name"]
        self.argspec = view["argspec"]
        self.modal_group = view["modal_group"]
        self.motion_code = view["motion_code"] if view["motion_code"] >= 0 else -2147483648
        self.remap_ngc = view["ngc"] or None
        self.remap_py = hooks.get("Body")
        self.prolog_func = hooks.get("Prolog")
        self.epilog_func = hooks.get("Epilog")


class Block:
    """The words of a line."""

    def __init__(self, view):
        words = view["words"] if view else {}
        fields = {}
        for letter in _LETTERS:
            value = words.get(letter)
            name = "d_number_float" if letter == "d" else letter + "_number"
            missing = _INTEGER_WORDS.get(letter, 0.0)
            fields[letter + "_flag"] = value is not None
            fields[name] = missing if value is None else type(missing)(value)
        fields["g_modes"] = _modes(view["g_modes"] if view else ())
        fields["m_modes"] = _modes(view["m_modes"] if view else ())
        fields["m_count"] = len(view["m_modes"]) if view else 0
        fields["comment"] = view["comment"] if view else ""
        fields["line_number"] = view["line"] if view else 0
        number = view["number"] if view else None
        fields["n_number"] = -1 if number is None else number
        fields["motion_to_be"] = fields["g_modes"][1]
        fields["builtin_used"] = view["builtin_used"] if view else False
        fields["executing_remap"] = Remap(view) if view else None
        fields["o_name"] = None
        fields["user_m"] = 0
        self.__dict__.update(fields)

    def __setattr__(self, name, value):
        raise AttributeError("the words of a line cannot be set: " + name)


def _modes(given):
    modes = [-1] * 16
    for group, code in given:
        modes[group] = code
    return modes


class BlocksArray:
    """The line in execution, and above it the lines whose remapped codes run."""

    def __init__(self, views):
        self._views = views

    def __len__(self):
        return len(self._views) + 1

    def __getitem__(self, index):
        if index < 0 or index > len(self._views):
            raise IndexError("there are %d blocks" % len(self))
        return Block(self._views[index - 1] if index else None)


class Params:
    """Parameters by number or name."""

    def __getitem__(self, key):
        if isinstance(key, str):
            return _host.named(key.lower())
        return _host.view["numbered"].get(_number(key), 0.0)

    def __setitem__(self, key, value):
        value = float(value)
        if not isinstance(key, str):
            _host.effect("Number", _number(key), value)
            _host.view["numbered"][_number(key)] = value
            return
        key = key.lower()
        _host.effect("Name", key, value)
        _host.view["globals" if key.startswith("_") else "locals"][key] = value

    def locals(self):
        return list(_host.view["locals"])

    def globals(self):
        return list(_host.view["globals"])

    def __call__(self):
        return self.locals() + self.globals()


class ParametersArray:
    """Parameters by number."""

    def __len__(self):
        return 5602

    def __getitem__(self, index):
        return this.params[index] if index else 0.0

    def __setitem__(self, index, value):
        this.params[int(index)] = value


def _number(key):
    key = int(key)
    if not 1 <= key <= 5601:
        raise IndexError("parameter %d: the numbers are 1 to 5601" % key)
    return key


class SpindleSpeedArray:
    """Programmed speeds of the spindles."""

    def __len__(self):
        return len(_host.view["speed"])

    def __getitem__(self, index):
        return _host.view["speed"][index]

    def __setitem__(self, index, value):
        _host.view["speed"][index] = float(value)
        _host.effect("Field", "speed.%d" % index, float(value))


class PmCartesian:
    def __init__(self, x=0.0, y=0.0, z=0.0):
        self.x, self.y, self.z = x, y, z


class EmcPose:
    def __init__(self, axes=None):
        axes = axes or {}
        for letter in "xyzabcuvw":
            setattr(self, letter, axes.get(letter, 0.0))
        self.tran = PmCartesian(self.x, self.y, self.z)


class CANON_TOOL_TABLE:
    """The tool in the spindle."""

    def __init__(self):
        numbered = this.params
        self.toolno = int(_host.view["fields"]["current_tool"])
        self.offset = EmcPose({a: numbered[5401 + n] for n, a in enumerate("xyzabcuvw")})
        self.diameter = numbered[5410]
        self.frontangle = numbered[5411]
        self.backangle = numbered[5412]
        self.orientation = int(numbered[5413])


class ToolTableArray:
    """The tool table, of which functions see the tool in the spindle."""

    def __len__(self):
        return 1

    def __getitem__(self, index):
        if index:
            raise IndexError("a function sees tool_table[0] alone, the tool in the spindle")
        return CANON_TOOL_TABLE()


class Interp:
    """The interpreter. What a function adds to it stays as long as the process."""

    def __init__(self):
        self.__dict__.update(_SIGNS)
        self.__dict__.update(_CONSTANT)
        self.__dict__.update(_errormsg="", params=Params(), parameters=ParametersArray(), speed=SpindleSpeedArray(),
                             tool_table=ToolTableArray())

    def __getattr__(self, name):
        fields = _host.view["fields"]
        if name in fields:
            value = fields[name]
            if name == "feed_mode":
                return FEED_MODE(int(value))
            if name in _FLAGS:
                return bool(value)
            return int(value) if name in _INTEGER_FIELDS else value
        raise AttributeError("'Interp' object has no attribute '%s'" % name)

    def __setattr__(self, name, value):
        fields = _host.view["fields"]
        if name in _WRITABLE:
            fields[name] = float(value)
            _host.effect("Field", name, float(value))
        elif name in _DERIVED:
            fields[name] = float(value)
        elif name in fields or name in _CONSTANT or isinstance(getattr(type(self), name, None), property):
            raise AttributeError("self.%s cannot be set" % name)
        else:
            self.__dict__[name] = value

    @property
    def blocks(self):
        return BlocksArray(_host.view["blocks"])

    @property
    def remap_level(self):
        return len(_host.view["blocks"])

    @property
    def filename(self):
        return _host.view["file"]

    @property
    def tool_offset(self):
        return EmcPose(_host.view["tool_offset"])

    @property
    def active_g_codes(self):
        motion, plane, unit, side, offset, system, path, lathe, distance, ijk, feed, spindle, retract = \
            _host.view["g_codes"]
        return [self.sequence_number, motion, -1, plane, side, unit, distance, feed, system, offset, retract, path,
                -1, spindle, ijk, lathe, -1]

    @property
    def active_settings(self):
        return [float(self.sequence_number), self.feed_rate, self.speed[0] if len(self.speed) else 0.0]

    def spindle_turning(self, spindle=0):
        return _host.view["turning"][spindle]

    def execute(self, text, line=0):
        """Executes lines. An error is an InterpreterException, unless throw_exceptions is 0."""
        for one in str(text).splitlines():
            failure = _host.execute(one)
            if failure is not None:
                if throw_exceptions:
                    raise InterpreterException(failure["message"], int(line) or failure["line"], one)
                self.set_errormsg(failure["message"])
                return INTERP_ERROR
        return INTERP_OK

    def find_tool_pocket(self, number):
        """Returns a status, and the pocket of a tool of the tool table."""
        if int(number) == 0:
            return (INTERP_OK, -1)
        slot = _host.slot(int(number))
        return (INTERP_ERROR, 0) if slot is None else (INTERP_OK, slot)

    def set_errormsg(self, text):
        self.__dict__["_errormsg"] = str(text)

    def get_errormsg(self):
        return self._errormsg

    def set_tool_parameters(self):
        """Does nothing: the tool's parameters are always those of the tool in the spindle."""

    def load_tool_table(self):
        return self.execute("G10 L0")

    def synch(self):
        """Does nothing: the interpreter's place is that of its last move."""
        return INTERP_OK

    def stack(self):
        return []


this = Interp()
