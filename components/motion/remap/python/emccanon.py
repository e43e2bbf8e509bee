"""Canonical calls of functions of remaps and O-words. Lengths are in units of the program."""

import enum

import _ferrule_remap as _host


def _enum(name, **members):
    made = enum.IntEnum(name, members)
    globals()[name] = made
    globals().update(made.__members__)


_enum("CANON_PLANE", CANON_PLANE_XY=1, CANON_PLANE_YZ=2, CANON_PLANE_XZ=3, CANON_PLANE_UV=4, CANON_PLANE_VW=5,
      CANON_PLANE_UW=6)
_enum("CANON_UNITS", CANON_UNITS_INCHES=1, CANON_UNITS_MM=2, CANON_UNITS_CM=3)
_enum("CANON_MOTION_MODE", CANON_EXACT_STOP=1, CANON_EXACT_PATH=2, CANON_CONTINUOUS=3)
_enum("CANON_FEED_SPEED_MODE", CANON_SYNCHED=1, CANON_INDEPENDENT=2)
_enum("CANON_DIRECTION", CANON_STOPPED=1, CANON_CLOCKWISE=2, CANON_COUNTERCLOCKWISE=3)
_enum("CANON_FEED_REFERENCE", CANON_WORKPIECE=1, CANON_XYZ=2)
_enum("CANON_SIDE", CANON_SIDE_RIGHT=1, CANON_SIDE_LEFT=2, CANON_SIDE_OFF=3)
_enum("CANON_AXIS", CANON_AXIS_X=1, CANON_AXIS_Y=2, CANON_AXIS_Z=3, CANON_AXIS_A=4, CANON_AXIS_B=5, CANON_AXIS_C=6,
      CANON_AXIS_U=7, CANON_AXIS_V=8, CANON_AXIS_W=9)

# Calls that the interpreter makes, with the numbers of arguments that they may have.
_CALLS = {
    "MESSAGE": (1,), "CANON_ERROR": (1,), "COMMENT": (1,), "LOG": (1,), "LOGOPEN": (1,), "LOGAPPEND": (1,),
    "LOGCLOSE": (0,), "DWELL": (1,), "SET_FEED_RATE": (1,), "SET_SPINDLE_SPEED": (1, 2), "SET_SPINDLE_MODE": (1, 2),
    "SET_FEED_MODE": (2,), "START_SPINDLE_CLOCKWISE": (0, 1, 2), "START_SPINDLE_COUNTERCLOCKWISE": (0, 1, 2),
    "STOP_SPINDLE_TURNING": (0, 1), "MIST_ON": (0,), "MIST_OFF": (0,), "FLOOD_ON": (0,), "FLOOD_OFF": (0,),
    "ENABLE_FEED_OVERRIDE": (0,), "DISABLE_FEED_OVERRIDE": (0,), "ENABLE_SPEED_OVERRIDE": (0, 1),
    "DISABLE_SPEED_OVERRIDE": (0, 1), "ENABLE_ADAPTIVE_FEED": (0,), "DISABLE_ADAPTIVE_FEED": (0,),
    "ENABLE_FEED_HOLD": (0,), "DISABLE_FEED_HOLD": (0,), "SET_MOTION_OUTPUT_BIT": (1,),
    "CLEAR_MOTION_OUTPUT_BIT": (1,), "SET_AUX_OUTPUT_BIT": (1,), "CLEAR_AUX_OUTPUT_BIT": (1,),
    "SET_MOTION_OUTPUT_VALUE": (2,), "SET_AUX_OUTPUT_VALUE": (2,), "SELECT_PLANE": (1,), "START_CHANGE": (0,),
    "PROGRAM_STOP": (0,), "OPTIONAL_PROGRAM_STOP": (0,), "STRAIGHT_TRAVERSE": (10,), "STRAIGHT_FEED": (10,),
    "ARC_FEED": (13,),
}
_MOVES = {"STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "ARC_FEED"}
_ENQUEUED = ("COMMENT", "DWELL", "FLOOD_OFF", "FLOOD_ON", "MIST_OFF", "MIST_ON", "SET_FEED_MODE", "SET_FEED_RATE",
             "SET_SPINDLE_MODE", "SET_SPINDLE_SPEED", "START_SPINDLE_CLOCKWISE", "START_SPINDLE_COUNTERCLOCKWISE",
             "STOP_SPINDLE_TURNING")
# Calls for which a function executes a line instead: what they would change belongs to the interpreter.
_LINES = ("ARC_FEED", "CLAMP_AXIS", "FINISH", "INIT_CANON", "IO_PLUGIN_CALL", "LOCK_ROTARY", "NURBS_FEED", "ON_RESET",
          "PALLET_SHUTTLE", "PLUGIN_CALL", "PROGRAM_END", "RELOAD_TOOLDATA", "RIGID_TAP", "SET_BLOCK_DELETE",
          "SET_CUTTER_RADIUS_COMPENSATION", "SET_G5X_OFFSET", "SET_G92_OFFSET", "SET_NAIVECAM_TOLERANCE",
          "SET_OPTIONAL_PROGRAM_STOP", "SET_PARAMETER_FILE_NAME", "SET_TOOL_TABLE_ENTRY", "SET_TRAVERSE_RATE",
          "SET_XY_ROTATION", "SPINDLE_RETRACT", "SPINDLE_RETRACT_TRAVERSE", "START_CUTTER_RADIUS_COMPENSATION",
          "START_SPEED_FEED_SYNCH", "STOP_CUTTER_RADIUS_COMPENSATION", "STOP_SPEED_FEED_SYNCH", "STRAIGHT_PROBE",
          "TURN_PROBE_OFF", "TURN_PROBE_ON", "UNLOCK_ROTARY", "UPDATE_TAG", "USE_LENGTH_UNITS", "USE_NO_SPINDLE_FORCE",
          "USE_TOOL_LENGTH_OFFSET", "WAIT")


def _call(name, counts):
    def call(*words):
        if len(words) not in counts:
            raise TypeError("%s takes %s arguments, not %d" % (name, " or ".join(map(str, counts)), len(words)))
        _host.effect("Call", name, [w if isinstance(w, str) else float(w) for w in words])
        if name in _MOVES:
            # The place is known again after the move.
            _host.refresh()
    call.__name__ = name
    return call


def _refused(name):
    def call(*_):
        raise NotImplementedError("emccanon.%s cannot be called by a function: execute a line with self.execute" % name)
    call.__name__ = name
    return call


globals().update({name: _refused(name) for name in _LINES})
globals().update({name: _call(name, counts) for name, counts in _CALLS.items()})
globals().update({"enqueue_" + name: globals()[name] for name in _ENQUEUED})

# Tools by their pockets, as find_tool_pocket has told them.
_tool_of = {}


def _tool(pocket):
    fields = _host.view["fields"]
    pocket = int(pocket)
    for tool, known in (("selected_tool", "selected_pocket"), ("current_tool", "current_pocket")):
        if fields[known] == pocket and fields[tool] >= 0:
            return int(fields[tool])
    if pocket <= 0:
        return 0
    if pocket not in _host.tools:
        raise ValueError("pocket %d: ask find_tool_pocket for it first" % pocket)
    return _host.tools[pocket]


def SELECT_TOOL(number):
    _host.effect("Call", "SELECT_TOOL", [float(number)])


def CHANGE_TOOL(pocket):
    _host.effect("Call", "CHANGE_TOOL", [float(_tool(pocket))])


def CHANGE_TOOL_NUMBER(pocket):
    _host.effect("Call", "CHANGE_TOOL_NUMBER", [float(_tool(pocket))])


def _field(name, kind=float):
    return lambda: kind(_host.view["fields"][name])


def _number(number):
    return lambda: _host.view["numbered"].get(number, 0.0)


def _offset(letter):
    return lambda: _host.view["tool_offset"][letter]


for _n, (_letter, _name) in enumerate(zip("XYZABCUVW", (
        "current_x", "current_y", "current_z", "AA_current", "BB_current", "CC_current", "u_current", "v_current",
        "w_current"))):
    globals()["GET_EXTERNAL_POSITION_" + _letter] = _field(_name)
    globals()["GET_EXTERNAL_PROBE_POSITION_" + _letter] = _number(5061 + _n)
    globals()["GET_EXTERNAL_TOOL_LENGTH_%sOFFSET" % _letter] = _offset(_letter.lower())

GET_EXTERNAL_FEED_RATE = _field("feed_rate")
GET_EXTERNAL_PLANE = _field("plane", lambda n: CANON_PLANE(int(n)))
GET_EXTERNAL_MIST = _field("mist", int)
GET_EXTERNAL_FLOOD = _field("flood", int)
GET_EXTERNAL_FEED_OVERRIDE_ENABLE = _field("feed_override", int)
GET_EXTERNAL_TOOL_SLOT = _field("current_pocket", int)
GET_EXTERNAL_SELECTED_TOOL_SLOT = _field("selected_pocket", int)
GET_EXTERNAL_PROBE_TRIPPED_VALUE = _number(5070)


def GET_EXTERNAL_ANGLE_UNITS():
    return 1.0


def GET_EXTERNAL_LENGTH_UNITS():
    return 1.0 if _host.named("_metric_machine") else 1 / 25.4


def GET_EXTERNAL_SPEED(spindle=0):
    return _host.view["speed"][spindle]


def GET_EXTERNAL_SPINDLE(spindle=0):
    return CANON_DIRECTION(_host.view["turning"][spindle])


def GET_EXTERNAL_QUEUE_EMPTY():
    """Returns 0: only yield INTERP_EXECUTE_FINISH waits for the machine."""
    return 0


for _name in ("ADAPTIVE_FEED_ENABLE", "ANALOG_INPUT", "AXIS_MASK", "DIGITAL_INPUT", "FEED_HOLD_ENABLE",
              "MOTION_CONTROL_MODE", "MOTION_CONTROL_NAIVECAM_TOLERANCE", "MOTION_CONTROL_TOLERANCE", "OFFSETS",
              "OFFSET_APPLIED", "PARAMETER_FILE_NAME", "PROBE_VALUE", "SPINDLE_OVERRIDE_ENABLE", "TC_FAULT",
              "TOOL_TABLE", "TRAVERSE_RATE"):
    globals()["GET_EXTERNAL_" + _name] = _refused("GET_EXTERNAL_" + _name)
GET_BLOCK_DELETE = _refused("GET_BLOCK_DELETE")
GET_OPTIONAL_PROGRAM_STOP = _refused("GET_OPTIONAL_PROGRAM_STOP")
