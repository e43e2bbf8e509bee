"""State of a machine."""

import _machine

from ._constants import *
from ._files import LETTERS, Facts, ini_file
from ._pages import is_stale, page, task_page

_TASK_STATES = (STATE_ESTOP, STATE_ESTOP_RESET, STATE_ON)
_MODES = (MODE_MANUAL, MODE_AUTO, MODE_MDI)
#: Names of waits, by their numbers in the snapshot.
_WAITS = ("nothing", "at-speed", "index", "orient", "spindle-stopped", "pause", "feed-hold", "feed-inhibit",
          "override", "spindle-speed", "m0", "m1", "m60", "step", "tool", "input", "program", "function", "page",
          "dwell", "iocontrol")
_TRAJ_MODES = (TRAJ_MODE_FREE, TRAJ_MODE_TELEOP, TRAJ_MODE_COORD)


def _padded(values, count):
    return tuple(values) + (0.0,) * (count - len(values))


def _bits(word):
    return tuple(word >> n & 1 for n in range(64))


def _ints(values):
    return tuple(map(int, values))


def _is_idle(s):
    return s._task["interpreter"] == 0


def _exec_state(s):
    if s._task["tool_awaited"] >= 0:
        return EXEC_WAITING_FOR_IO
    if not _is_idle(s) and s._motion["queue"]:
        return EXEC_WAITING_FOR_MOTION
    return EXEC_DONE


def _state(s):
    busy = not _is_idle(s) or not s._motion["in_position"] or s._task["mdi_queue"]
    return RCS_EXEC if busy else RCS_DONE


def _gcodes(s):
    (motion, plane, unit, side, tool, origin, path, diameter, distance, arcs, feed, css,
     retract) = s._task["g_codes"]
    return (s._task["line_read"], motion, -1, plane, side, unit, distance, feed, origin, tool,
            retract, path, -1, css, arcs, diameter, 922)


def _mcodes(s):
    task = s._task
    turning = {1: 3, -1: 4}.get(task["direction"][0], 5)
    mist = 7 if task["mist"] else -1 if task["flood"] else 9
    return (task["line_read"], -1, turning, -1, mist, 8 if task["flood"] else -1, 48, -1, 53, 0)


def _axis(s):
    motion, facts = s._motion, s._facts
    speeds = dict(zip(facts.coordinates, motion["joint_velocity"]))
    known = facts.kinematics_type == KINEMATICS_IDENTITY
    return tuple({"velocity": speeds.get(n, 0.0) if known else 0.0, **facts.axes[n]}
                 for n in range(len(LETTERS)))


def _joint(s):
    m = s._motion
    homed, homing, fault = m["joint_homed"], m["joint_homing"], m["joint_fault"]
    low, high, errors = m["joint_at_min"], m["joint_at_max"], m["joint_error"]
    output, measured, velocity = m["joint_position"], m["joint_feedback"], m["joint_velocity"]
    count, lower, upper = m["joints"], m["joint_min_limit"], m["joint_max_limit"]
    active, below, above = m["joint_active"], m["joints_below"], m["joints_above"]
    out = []
    for n, facts in enumerate(s._facts.joints):
        ferror = output[n] - measured[n]
        out.append({
            **facts,
            "min_position_limit": lower[n] if n < count else facts["min_position_limit"],
            "max_position_limit": upper[n] if n < count else facts["max_position_limit"],
            "ferror_current": ferror,
            "ferror_highmark": s._highmark(n, abs(ferror)),
            "output": output[n],
            "input": measured[n],
            "velocity": velocity[n],
            "inpos": int(velocity[n] == 0.0),
            "homing": int(homing[n]),
            "homed": int(homed[n]),
            "fault": int(fault[n] or errors[n]),
            "enabled": int(m["enabled"] and active[n]),
            "min_soft_limit": below >> n & 1,
            "max_soft_limit": above >> n & 1,
            "min_hard_limit": int(low[n]),
            "max_hard_limit": int(high[n]),
            "override_limits": int(m["overriding_limits"]),
        })
    return tuple(out)


def _limit(s):
    m = s._motion
    low, high = m["joint_at_min"], m["joint_at_max"]
    below, above = m["joints_below"], m["joints_above"]
    return tuple(low[n] | high[n] << 1 | (below >> n & 1) << 2 | (above >> n & 1) << 3
                 for n in range(MAX_JOINTS))


def _spindle(s):
    m = s._motion
    speed, scale, brake = m["spindle_speed"], m["spindle_override"], m["spindle_brake"]
    counts, orient, fault = s._task["spindle_override_counts"], m["spindle_orient_state"], m["spindle_orient_fault"]
    return tuple({
        "brake": int(brake[n]),
        "direction": (speed[n] > 0) - (speed[n] < 0),
        "enabled": int(speed[n] != 0.0),
        "override_enabled": counts[n],
        "speed": speed[n],
        "override": scale[n],
        "homed": False,
        "orient_state": orient[n],
        "orient_fault": fault[n],
    } for n in range(8))


def _pocket_of(s, number):
    """Returns the place of a tool in `tool_table`, or -1."""
    rows = s._facts.tools()
    return next((n + 1 for n, row in enumerate(rows) if row[0] == number), -1)


def _from_pocket(s):
    number = s._task["tool"]
    return next((row[1] for row in s._facts.tools() if row[0] == number), 0)


def _motion(name, to=None):
    return (lambda s: to(s._motion[name])) if to else (lambda s: s._motion[name])


def _task(name, to=None):
    return (lambda s: to(s._task[name])) if to else (lambda s: s._task[name])


def _fact(name):
    return lambda s: getattr(s._facts, name)


def _always(value):
    return lambda s: value


#: Each field, and how it is read.
_FIELDS = {
    "acceleration": _fact("acceleration"),
    "active_queue": _motion("queue", lambda n: min(n, 1)),
    "actual_position": _motion("pose_feedback"),
    "adaptive_feed_enabled": _motion("adaptive_feed"),
    "ain": _motion("analog_in", lambda v: _padded(v, 64)),
    "angular_units": _fact("angular_units"),
    "aout": _motion("analog_out", lambda v: _padded(v, 64)),
    "axis": _axis,
    "axis_mask": _fact("axis_mask"),
    "block_delete": _task("block_delete"),
    "call_level": _task("calls"),
    "command": lambda s: s._task.text("command"),
    "current_line": _task("line"),
    "current_vel": _motion("velocity"),
    "cycle_time": _fact("cycle_time"),
    "debug": _fact("debug"),
    "delay_left": _task("delay_left"),
    "din": _motion("digital_in", _bits),
    "distance_to_go": _motion("distance_to_go"),
    "dout": _motion("digital_out", _bits),
    "dtg": _motion("axis_to_go"),
    "echo_serial_number": lambda s: _command_serial(),
    "enabled": _motion("enabled"),
    "estop": _task("state", lambda n: int(n == 0)),
    "exec_state": _exec_state,
    "feed_hold_enabled": _motion("feed_hold"),
    "feed_override_enabled": _task("feed_override_counts"),
    "feedrate": _task("feed_override"),
    "file": lambda s: s._task.text("file"),
    "flood": _task("flood", int),
    "g5x_index": _task("system"),
    "g5x_offset": _task("g5x_offset"),
    "g92_offset": _task("g92_offset"),
    "gcodes": _gcodes,
    "homed": _motion("joint_homed", _ints),
    "ini_filename": _fact("path"),
    "inpos": _motion("in_position"),
    "input_timeout": _task("input_timeout"),
    "interp_state": _task("interpreter", lambda n: n + 1),
    "interpreter_errcode": _always(0),
    "joint": _joint,
    "joint_actual_position": _motion("joint_feedback"),
    "joint_position": _motion("joint_position"),
    "joints": _motion("joints"),
    "kinematics_type": _fact("kinematics_type"),
    "limit": _limit,
    "linear_units": _fact("linear_units"),
    "lube": _task("lube", int),
    "lube_level": _task("lube_level", int),
    "max_acceleration": _fact("max_acceleration"),
    "max_velocity": _motion("max_velocity"),
    "mcodes": _mcodes,
    "misc_error": _motion("misc_errors", _bits),
    "mist": _task("mist", int),
    "motion_id": _motion("line"),
    "motion_line": _motion("line"),
    "motion_mode": _motion("mode", _TRAJ_MODES.__getitem__),
    "motion_type": _motion("motion_type"),
    "num_extrajoints": _always(0),
    "optional_stop": _task("optional_stop"),
    "paused": _motion("paused"),
    "pocket_prepped": lambda s: _pocket_of(s, s._task["tool_prepared"] or None),
    "position": _motion("pose"),
    "probe_tripped": _motion("probe_found"),
    "probe_val": _motion("probe_input", int),
    "probed_position": _motion("probe_measured"),
    "probing": _motion("probing"),
    "program_units": lambda s: 1 if s._task["g_codes"][2] == 200 else 2,
    "queue": _motion("queue"),
    "queue_full": _motion("queue", lambda n: n >= 1000),
    "queued_mdi_commands": _task("mdi_queue"),
    "rapidrate": _task("rapid_override"),
    "read_line": _task("line_read"),
    "rotation_xy": _task("rotation"),
    "settings": lambda s: (float(s._task["line_read"]), s._task["feed"], abs(s._task["speed"][0]), 0.0, 0.0),
    "spindle": _spindle,
    "spindles": _motion("spindles"),
    "state": _state,
    "task_mode": _task("mode", _MODES.__getitem__),
    "task_paused": _task("interpreter", lambda n: int(n == 2)),
    "task_state": _task("state", _TASK_STATES.__getitem__),
    "tool_from_pocket": _from_pocket,
    "tool_in_spindle": _task("tool"),
    "tool_offset": _task("tool_offset"),
    "tool_table": lambda s: s._facts.tool_table(s._task["tool"]),
    "velocity": _always(0.0),
    "wait": _task("wait", _WAITS.__getitem__),
    "wait_ends": _task("wait_ends"),
    "wait_number": _task("wait_number"),
    "wait_since": _task("wait_since"),
    "wait_text": lambda s: s._task.text("wait_text"),
    "wait_until": _task("wait_until"),
}


def _command_serial():
    from . import _command

    return _command.serial


class stat:
    """State of the machine at the last `poll`."""

    def __init__(self):
        self._channel = None
        self._pages = None
        self._highest = {}

    def _open(self):
        if self._channel is None:
            self._channel = _machine.Channel()
        motion = page(self._channel, "motion.status")
        pages = motion, task_page(self._channel, motion)
        if self._pages is None:
            self._facts = Facts(ini_file(self._channel))
        self._pages = pages
        self._motion, self._task = pages

    def __getattr__(self, name):
        if name not in ("_motion", "_task", "_facts"):
            raise AttributeError("'linuxcnc.stat' object has no attribute '%s'" % name)
        self._open()
        return self.__dict__[name]

    def _highmark(self, joint, ferror):
        self._highest[joint] = max(ferror, self._highest.get(joint, 0.0))
        return self._highest[joint]

    def poll(self):
        """Updates the state."""
        if self._pages is None or any(map(is_stale, self._pages)):
            self._open()
        for one in self._pages:
            one.poll()


for _name, _read in _FIELDS.items():
    setattr(stat, _name, property(_read))
