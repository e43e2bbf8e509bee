"""Commands to a machine."""

import os
import time

import _machine

from . import _messages
from ._constants import *

#: Number of the last command of this program.
serial = 0
#: Seconds between two looks whether a command has ended.
_INTERVAL = 0.005
_SPINDLE_STEP = 100.0
_MODES = {MODE_MANUAL: "manual", MODE_AUTO: "auto", MODE_MDI: "mdi"}
_STATES = {STATE_ESTOP: "estop", STATE_ESTOP_RESET: "estop-reset", STATE_OFF: "off", STATE_ON: "on"}
#: States that are stops of the machine: no task is asked.
_STOPS = ("estop", "off")
_TRAJ_MODES = {TRAJ_MODE_FREE: "free", TRAJ_MODE_COORD: "coord", TRAJ_MODE_TELEOP: "teleop"}
_AXES = "xyzabcuvw"


#: Targets of continuous jogs of this process, and the connection whose end ends them.
_jogs = set()
_keeper = None


def _keep(target, jogs):
    """Lets the jog of a target end with this process, however that ends."""
    global _keeper
    before = set(_jogs)
    (_jogs.add if jogs else _jogs.discard)(target)
    if _jogs == before and not jogs:
        return
    commands = [("motion.jog-stop", [each]) for each in sorted(_jogs)]
    try:
        if _keeper is not None:
            _keeper.at_end(commands)
            return
    except _machine.error:
        # The connection was to a machine that has ended.
        pass
    try:
        _keeper = _machine.Channel()
        _keeper.at_end(commands)
    except _machine.error:
        _keeper = None
        _jogs.discard(target)
        raise


def _forked():
    """Leaves the jogs to the process that has begun them."""
    global _keeper
    _keeper = None
    _jogs.clear()


os.register_at_fork(after_in_child=_forked)


def _known(table, number, what):
    try:
        return table[number]
    except KeyError:
        raise _machine.error("%s should be one of %s" % (what, ", ".join(map(str, table)))) from None


def _bit(on):
    return "TRUE" if on else "FALSE"


def _number(value):
    return repr(float(value))


class command:
    """Sends commands. A refusal is a message on the error channel, and the result of `wait_complete`.

    On a machine without a task, states, homing, overrides, resume and step are those of motion and iocontrol; programs and lines
    of G-code are refused. A machine that moves and that nothing stops is not commanded: the first command raises `error`.
    """

    def __init__(self):
        self._channel = None
        self._tickets = []
        self._status = RCS_DONE
        self._page = None
        self._speeds = {}

    @property
    def serial(self):
        """Number of the last command."""
        return serial

    def _open(self):
        if self._channel is None:
            channel = _machine.Channel()
            channel.check_stops()
            self._channel = channel
        return self._channel

    def _begin(self):
        global serial
        channel = self._open()
        serial += 1
        self._tickets, self._status = [], RCS_DONE
        return channel

    def _follow(self, channel, ticket):
        entry = (channel, ticket)
        self._tickets.append(entry)
        _messages.follow(entry)

    def _refuse(self, why):
        self._status = RCS_ERROR
        _messages.add(OPERATOR_ERROR, why)

    def _send(self, name, *args):
        channel = self._begin()
        try:
            ticket = channel.order(name, *args)[1]
        except _machine.error as why:
            self._refuse(str(why))
            return
        if ticket is not None:
            self._follow(channel, ticket)

    def _stop(self, stop):
        """Stops the machine: every command of the stop is sent, although one may be refused."""
        channel = self._begin()
        try:
            tickets, refused = channel.stop(stop)
        except _machine.error as why:
            self._refuse(str(why))
            return
        for ticket in tickets:
            self._follow(channel, ticket)
        for why in refused:
            self._refuse(why)

    def _succeed(self):
        global serial
        serial += 1
        self._tickets, self._status = [], RCS_DONE

    def wait_complete(self, timeout=5.0):
        """Waits for the last command. Returns RCS_DONE or RCS_ERROR, or -1 after `timeout` seconds."""
        end = time.monotonic() + timeout
        while self._tickets:
            channel, number = entry = self._tickets[0]
            why = channel.ticket(number)
            if why is not None:
                if entry in _messages.pending:
                    _messages.pending.remove(entry)
                    if why:
                        _messages.fail(why)
                del self._tickets[0]
                if why:
                    self._status = RCS_ERROR
            elif time.monotonic() >= end:
                return -1
            else:
                time.sleep(_INTERVAL)
        return self._status

    # State and mode

    def state(self, state):
        """state(STATE): STATE_ESTOP, STATE_ESTOP_RESET, STATE_OFF or STATE_ON."""
        name = _known(_STATES, state, "Machine state")
        if name in _STOPS:
            self._stop(name)
        else:
            self._send("task." + name)

    def mode(self, mode):
        """mode(MODE): MODE_MANUAL, MODE_AUTO or MODE_MDI."""
        self._send("task.mode", "mode=" + _known(_MODES, mode, "Mode"))

    def teleop_enable(self, on):
        """teleop_enable(ON): jogs move axes, or joints."""
        self._send("motion.mode", "mode=" + ("teleop" if on else "free"))

    def traj_mode(self, mode):
        """traj_mode(MODE): TRAJ_MODE_FREE, TRAJ_MODE_COORD or TRAJ_MODE_TELEOP."""
        self._send("motion.mode", "mode=" + _known(_TRAJ_MODES, mode, "Mode"))

    # Programs

    def program_open(self, file):
        """program_open(FILE): opens a program."""
        self._send("task.open", "file=" + file)

    def auto(self, what, line=0):
        """auto(AUTO_RUN) or auto(AUTO_PAUSE | AUTO_RESUME | AUTO_STEP | AUTO_REVERSE | AUTO_FORWARD)."""
        if what == AUTO_RUN:
            if line > 1:
                raise ValueError("AUTO_RUN begins at the first line; task.run-from and task.confirm begin at another")
            self._send("task.run")
            return
        commands = {AUTO_PAUSE: "motion.pause", AUTO_RESUME: "task.resume", AUTO_STEP: "task.step",
                    AUTO_REVERSE: "motion.reverse", AUTO_FORWARD: "motion.forward"}
        name = _known(commands, what, "Command")
        if what == AUTO_PAUSE:
            self._stop("pause")
        else:
            self._send(name)

    def mdi(self, text):
        """mdi(TEXT): executes a line."""
        if len(text) > 255:
            raise ValueError("MDI commands limited to 255 characters")
        self._send("task.mdi", 'text="%s"' % text)

    def abort(self):
        """Ends program, MDI and jogs."""
        self._stop("abort")

    def reset_interpreter(self):
        """Does nothing: the state of the interpreter is always that of the last line in execution."""
        self._succeed()

    def task_plan_synch(self):
        """Does nothing: the interpreter starts each job from the place where the machine is."""
        self._succeed()

    def set_optional_stop(self, on):
        """set_optional_stop(ON): M1 pauses."""
        self._send("task.optional-stop", "on=" + _bit(on))

    def set_block_delete(self, on):
        """set_block_delete(ON): lines that begin with / are left out."""
        self._send("task.block-delete", "on=" + _bit(on))

    # Joints and axes

    def home(self, joint):
        """home(JOINT): homes a joint, or all for -1."""
        self._send("task.home", "joint=" + ("all" if joint == -1 else str(joint)))

    def unhome(self, joint):
        """unhome(JOINT): forgets the position of a joint, or of all for -1."""
        self._send("motion.unhome", "joint=" + ("all" if joint == -1 else str(joint)))

    def jog(self, what, is_joint, index, speed=None, distance=None):
        """jog(JOG_STOP, JOINT_FLAG, INDEX), jog(JOG_CONTINUOUS, …, SPEED) or jog(JOG_INCREMENT, …, SPEED, DISTANCE)."""
        if not is_joint and not 0 <= index < len(_AXES):
            raise _machine.error("axis is %s, should be 0 to %d" % (index, len(_AXES) - 1))
        target = "joint=%d" % index if is_joint else "axis=" + _AXES[index]
        if what == JOG_STOP:
            self._send("motion.jog-stop", target)
            self._release(target)
        elif what == JOG_CONTINUOUS and speed is not None:
            try:
                _keep(target, True)
            except _machine.error as why:
                self._succeed()
                self._refuse(str(why))
                return
            self._send("motion.jog", target, "velocity=" + _number(speed))
        elif what == JOG_INCREMENT and speed is not None and distance is not None:
            distance = -distance if speed < 0 else distance
            self._send("motion.jog", target, "velocity=" + _number(abs(speed)), "distance=" + _number(distance))
            self._release(target)
        else:
            raise _machine.error("jog() needs JOG_STOP, JOG_CONTINUOUS with a speed, or JOG_INCREMENT with speed and distance")

    def _release(self, target):
        try:
            _keep(target, False)
        except _machine.error:
            # Without a machine there is no jog.
            pass

    def override_limits(self):
        """Lets a joint be jogged off its limit switch."""
        self._send("motion.override-limits")

    def set_min_limit(self, joint, limit):
        """set_min_limit(JOINT, LIMIT): sets the lower end of a joint's travel."""
        self._send("motion.configure", "joint=%d" % joint, "min-limit=" + _number(limit))

    def set_max_limit(self, joint, limit):
        """set_max_limit(JOINT, LIMIT): sets the upper end of a joint's travel."""
        self._send("motion.configure", "joint=%d" % joint, "max-limit=" + _number(limit))

    # Speeds

    def feedrate(self, scale):
        """feedrate(SCALE): sets the feed override."""
        self._send("task.feed-override", "scale=" + _number(scale))

    def rapidrate(self, scale):
        """rapidrate(SCALE): sets the override of rapid moves, 0 to 1."""
        self._send("task.rapid-override", "scale=" + _number(min(max(scale, 0.0), 1.0)))

    def maxvel(self, velocity):
        """maxvel(VELOCITY): sets the highest velocity of coordinated moves."""
        self._send("motion.configure", "max-velocity=" + _number(velocity))

    def set_feed_override(self, on):
        """set_feed_override(ON): lets the overrides of feeds and rapid moves count."""
        self._send("task.mdi-brief", 'text="M50 P%d"' % bool(on))

    def set_feed_hold(self, on):
        """set_feed_hold(ON): lets motion.feed-hold count."""
        self._send("motion.feed", "hold=" + _bit(on))

    def set_adaptive_feed(self, on):
        """set_adaptive_feed(ON): lets motion.adaptive-feed count."""
        self._send("motion.feed", "adaptive=" + _bit(on))

    # Spindles, coolant, outputs

    def spindle(self, direction, speed=None, spindle=0, wait=0):
        """spindle(DIRECTION[, SPEED[, SPINDLE]]): turns a spindle, changes its speed by a step, or stops it."""
        turning = self._turning(spindle)
        if direction in (SPINDLE_FORWARD, SPINDLE_REVERSE):
            speed = direction * abs(float(speed or 0.0))
        elif direction == SPINDLE_OFF:
            speed = 0.0
        elif direction in (SPINDLE_INCREASE, SPINDLE_DECREASE):
            if turning == 0.0:
                self._succeed()
                return
            step = _SPINDLE_STEP if direction == SPINDLE_INCREASE else -_SPINDLE_STEP
            speed = (1 if turning > 0 else -1) * max(abs(turning) + step, 0.0)
        elif direction == SPINDLE_CONSTANT:
            self._succeed()
            return
        else:
            raise _machine.error("spindle() needs SPINDLE_FORWARD, SPINDLE_REVERSE, SPINDLE_OFF, SPINDLE_INCREASE, "
                                 "SPINDLE_DECREASE or SPINDLE_CONSTANT")
        brake = "brake=" + _bit(speed == 0.0)
        self._send("motion.spindle", "spindle=%d" % spindle, "speed=" + _number(speed), brake)

    def _turning(self, spindle):
        if self._page is None:
            self._page = _machine.Page(_machine.Channel(), "motion.status")
        self._page.poll()
        return self._page["spindle_speed"][spindle]

    def brake(self, on, spindle=0):
        """brake(BRAKE_ENGAGE | BRAKE_RELEASE[, SPINDLE])."""
        self._send("motion.spindle", "spindle=%d" % spindle, "brake=" + _bit(on))

    def spindleoverride(self, scale, spindle=0):
        """spindleoverride(SCALE[, SPINDLE]): sets the override of a spindle."""
        self._send("task.spindle-override", "spindle=%d" % spindle, "scale=" + _number(scale))

    def set_spindle_override(self, on, spindle=0):
        """set_spindle_override(ON[, SPINDLE]): lets the override of a spindle count."""
        self._send("task.mdi-brief", 'text="M51 P%d $%d"' % (bool(on), spindle))

    def flood(self, on):
        """flood(FLOOD_ON | FLOOD_OFF)."""
        self._send("iocontrol.coolant", "flood=" + _bit(on))

    def mist(self, on):
        """mist(MIST_ON | MIST_OFF)."""
        self._send("iocontrol.coolant", "mist=" + _bit(on))

    def set_digital_output(self, index, on):
        """set_digital_output(INDEX, ON): sets motion.digital-out-NN."""
        self._send("motion.digital-out", "index=%d" % index, "value=" + _bit(on))

    def set_analog_output(self, index, value):
        """set_analog_output(INDEX, VALUE): sets motion.analog-out-NN."""
        self._send("motion.analog-out", "index=%d" % index, "value=" + _number(value))

    # Tools

    def load_tool_table(self):
        """Reads the tool table again."""
        self._send("task.mdi-brief", 'text="G10 L0"')

    def tool_offset(self, number, z, x, diameter, front=0.0, back=0.0, orientation=0):
        """tool_offset(TOOL, Z, X, DIAMETER, FRONT, BACK, ORIENTATION): changes an entry of the tool table."""
        values = (number, z, x, diameter / 2.0, front, back, orientation)
        self._send("task.mdi-brief", 'text="G10 L1 P%d Z%.9g X%.9g R%.9g I%.9g J%.9g Q%d"' % values)

    # Messages

    def error_msg(self, text):
        """error_msg(TEXT): shows an error."""
        self._tell(OPERATOR_ERROR, text)

    def text_msg(self, text):
        """text_msg(TEXT): shows a text."""
        self._tell(OPERATOR_TEXT, text)

    def display_msg(self, text):
        """display_msg(TEXT): shows a message."""
        self._tell(OPERATOR_DISPLAY, text)

    def _tell(self, kind, text):
        self._succeed()
        _messages.add(kind, text)

    def debug(self, level):
        """debug(LEVEL): accepted for programs that set it; messages of Ferrule have levels of HAL."""
        self._succeed()
