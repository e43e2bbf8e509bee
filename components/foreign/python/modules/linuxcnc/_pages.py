"""Snapshots of a machine that starts.

Until its components are loaded, it is in e-stop and all numbers are zero. Once its scripts have ended, missing motion is an
error; a machine without a task has the state that motion knows.
"""

import os
import time

import _machine

_NINE = (0.0,) * 9
_ANALOG = (0.0,) * 8
_JOINTS, _JOINT_BITS = (0.0,) * 16, (False,) * 16
_SPINDLES, _SPINDLE_COUNTS, _SPINDLE_BITS = (0.0,) * 8, (0,) * 8, (False,) * 8

#: Components that write the snapshots.
_COMPONENTS = {"motion.status": "motmod", "task.status": "task"}

#: The fields that this module reads, before the component writes them.
BLANK = {
    "motion.status": {
        "adaptive_feed": False, "analog_in": _ANALOG, "analog_out": _ANALOG, "axis_to_go": _NINE,
        "digital_in": 0, "digital_out": 0, "distance_to_go": 0.0, "enabled": False,
        "feed_hold": False, "in_position": False, "joint_active": _JOINT_BITS,
        "joint_at_max": _JOINT_BITS, "joint_at_min": _JOINT_BITS, "joint_error": _JOINT_BITS,
        "joint_fault": _JOINT_BITS, "joint_feedback": _JOINTS, "joint_homed": _JOINT_BITS,
        "joint_homing": _JOINT_BITS, "joint_max_limit": _JOINTS, "joint_min_limit": _JOINTS,
        "joint_position": _JOINTS, "joint_velocity": _JOINTS, "joints": 0, "joints_above": 0,
        "joints_below": 0, "line": 0, "max_velocity": 0.0, "misc_errors": 0, "mode": 0,
        "motion_type": 0, "overriding_limits": False, "paused": False, "pose": _NINE,
        "pose_feedback": _NINE, "probe_found": False, "probe_input": False, "probe_measured": _NINE,
        "probing": False, "queue": 0, "spindle_brake": _SPINDLE_BITS,
        "spindle_orient_fault": _SPINDLE_COUNTS, "spindle_orient_state": _SPINDLE_COUNTS,
        "spindle_override": _SPINDLES, "spindle_speed": _SPINDLES, "spindles": 0, "velocity": 0.0,
    },
    "task.status": {
        "block_delete": False, "calls": 0, "command": "", "delay_left": 0.0,
        "direction": _SPINDLE_COUNTS, "feed": 0.0, "feed_override": 0.0,
        "feed_override_counts": False, "file": "", "flood": False, "g5x_offset": _NINE,
        "g92_offset": _NINE, "g_codes": (0,) * 13, "input_timeout": False, "interpreter": 0,
        "line": 0, "line_read": 0, "lube": False, "lube_level": False, "mdi_queue": 0,
        "message": "", "message_level": 0, "messages": 0, "mist": False, "mode": 0,
        "optional_stop": False, "rapid_override": 0.0, "rotation": 0.0, "speed": _SPINDLES,
        "spindle_override_counts": _SPINDLE_BITS, "state": 0, "system": 0, "tool": 0,
        "tool_awaited": -1, "tool_offset": _NINE, "tool_prepared": 0, "wait": 0, "wait_ends": False,
        "wait_number": 0, "wait_since": 0.0, "wait_text": "", "wait_until": -1.0,
    },
}


class Blank:
    """A snapshot that is not there yet."""

    def __init__(self, name):
        self._fields = BLANK[name]

    def is_stale(self):
        """Returns whether the component may be there by now: a machine that starts is asked at each look."""
        return True

    def __contains__(self, name):
        return name in self._fields

    def __getitem__(self, name):
        return self._fields[name]

    text = __getitem__

    def poll(self):
        """Nothing has been written."""


#: Fields of the task that motion knows where there is no task.
_FROM_MOTION = {
    "feed_override": lambda m: m["feed_override"],
    "rapid_override": lambda m: m["rapid_override"],
    "state": lambda m: 2 if m["enabled"] else 0 if m["estop"] else 1,
    "tool_offset": lambda m: m["tool_offset"],
    "wait": lambda m: m["wait"],
    "wait_ends": lambda m: m["wait_ends"],
    "wait_number": lambda m: m["wait_number"],
    "wait_since": lambda m: m["wait_since_ns"] * 1e-9,
}


class WithoutTask(Blank):
    """The state of a machine without a task, as far as motion knows it: manual mode, no program, no G-code."""

    def __init__(self, motion):
        super().__init__("task.status")
        self._motion = motion
        self._since = time.monotonic()

    def is_stale(self):
        """Returns whether a task may have been loaded: that is asked once in a second."""
        return time.monotonic() - self._since > 1.0

    def __getitem__(self, name):
        read = _FROM_MOTION.get(name)
        return read(self._motion) if read else self._fields[name]

    text = __getitem__


def task_page(channel, motion):
    """Returns the snapshot of the task; on a machine that has motion alone, what motion knows of it."""
    try:
        return page(channel, "task.status")
    except _machine.error:
        if isinstance(motion, Blank) or channel.loaded("task")[1] is not None:
            raise
        return WithoutTask(motion)


def is_stale(page):
    """Returns whether a page is to be opened again."""
    return page is None or isinstance(page, Blank) and page.is_stale()


def page(channel, name):
    """Returns a snapshot, or a blank one to a program that a machine's scripts start before the component."""
    # Asked first: a component that loads meanwhile is found.
    is_starting = channel.is_starting()
    try:
        return _machine.Page(channel, name)
    except _machine.error as why:
        if "INI_FILE_NAME" not in os.environ:
            raise
        if not is_starting:
            text = "%s: the scripts of the machine have ended without 'loadrt %s'"
            raise _machine.error(text % (why, _COMPONENTS[name])) from None
        return Blank(name)
