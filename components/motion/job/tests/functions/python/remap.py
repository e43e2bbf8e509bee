import os

import emccanon
from emccanon import MESSAGE
from interpreter import *

calls = 0


def words(self, **words):
    MESSAGE("words %s" % sorted(words.items()))
    block = self.blocks[self.remap_level]
    MESSAGE("q %s %g, remap %s %s" % (block.q_flag, block.q_number, block.executing_remap.name,
                                      block.executing_remap.argspec))
    return INTERP_OK


def positional(self, *values):
    MESSAGE("values %s" % (values,))


def before(self, **words):
    self.params["given"] = 3 * words["p"]
    return INTERP_OK


def behind(self, **words):
    MESSAGE("behind: value %g of %s, given %g" % (self.return_value, bool(self.value_returned), self.params["given"]))
    return INTERP_OK


def waits(self):
    self.execute("G1 X1 F100")
    yield INTERP_EXECUTE_FINISH
    MESSAGE("waited at %g" % self.current_x)
    self.execute("G38.2 X9 F50")
    MESSAGE("probed: %g at %g" % (self.params[5070], self.params[5061]))
    yield INTERP_OK


def catches(self):
    try:
        self.execute("G1 Q3", 12)
    except InterpreterException as error:
        MESSAGE("%d: '%s' - %s" % (error.line_number, error.line_text, error.error_message))
    try:
        self.params["nobody"]
    except RuntimeError as error:
        MESSAGE(str(error))
    try:
        self.execute("o1 while [1]")
    except InterpreterException as error:
        MESSAGE(error.error_message)
    return INTERP_OK


def raises(self):
    return {}["key"]


def endless(self):
    while True:
        pass


def crashes(self):
    os.kill(os.getpid(), 9)


def refuses(self):
    self.set_errormsg("no air")
    return INTERP_ERROR


def canon(self):
    emccanon.DWELL(0.5)
    emccanon.STRAIGHT_FEED(0, 1, 2, 3, 0, 0, 0, 0, 0, 0)
    MESSAGE("at %g %g %g" % (self.current_x, self.current_y, self.current_z))
    emccanon.SET_MOTION_OUTPUT_BIT(3)
    emccanon.CLEAR_AUX_OUTPUT_BIT(2)
    emccanon.enqueue_SET_SPINDLE_SPEED(300)
    emccanon.START_SPINDLE_CLOCKWISE(0, 1)
    emccanon.SELECT_PLANE(emccanon.CANON_PLANE_XZ)
    emccanon.ARC_FEED(0, 3, 3, 3, 2, 1, 2, 0, 0, 0, 0, 0, 0)


def state(self):
    global calls
    calls += 1
    self.feed_rate = 250
    self.speed[0] = 900
    MESSAGE("call %d, %s, feed %g, speed %g" % (calls, self.mark, self.params["_feed"], self.params["_rpm"]))
    MESSAGE("tools %s %s %s" % (self.find_tool_pocket(2), self.find_tool_pocket(0), self.find_tool_pocket(9)))
    self.params[31] = 4.5
    self.params["_shared"] = self.params[31] + 1
    MESSAGE("task %d, units %d, plane %d, mode %d" % (self.task, self.length_units, self.plane, self.motion_mode))
    self.current_x = 3


def strange(self):
    return [1]


def leaves(self):
    raise SystemExit(1)


def spiral(self, **words):
    for turn in range(3):
        self.execute("G1 X%g Y%g" % (words["x"] + turn, words["y"] - turn), turn)
    return INTERP_OK


def change_before(self):
    if self.selected_tool < 0:
        return "no tool is selected"
    self.params["tool"] = self.selected_tool
    self.params["pocket"] = self.selected_pocket


def change_behind(self):
    emccanon.CHANGE_TOOL(self.selected_pocket)
    self.current_pocket = self.selected_pocket
    self.selected_tool = -1
    yield INTERP_EXECUTE_FINISH
    MESSAGE("changed to %d in pocket %d" % (self.current_tool, self.current_pocket))
    yield INTERP_OK


def change_and_go(self):
    emccanon.CHANGE_TOOL(self.selected_pocket)
    self.execute("G0 X50")


def change_and_fail(self):
    emccanon.CHANGE_TOOL(self.selected_pocket)
    raise RuntimeError("stuck")


def change_anyway(self):
    try:
        self.execute("M415")
    except InterpreterException as error:
        MESSAGE(error.error_message)
    self.execute("G0 X50")


def modal(self):
    emccanon.SET_FEED_RATE(10)
    emccanon.SET_SPINDLE_SPEED(0, 300)
    emccanon.SET_SPINDLE_MODE(0, 800)
    emccanon.DISABLE_SPEED_OVERRIDE(0)
    emccanon.ENABLE_ADAPTIVE_FEED()
    emccanon.DISABLE_FEED_HOLD()
    emccanon.SET_FEED_MODE(0, 1)


def states_tool(self):
    self.current_tool = 2


def states_tool_to_machine(self):
    self.find_tool_pocket(2)
    self.current_tool = 2
    emccanon.CHANGE_TOOL_NUMBER(self.current_pocket)
    self.execute("G43")


def no_spindle(self, p):
    if p == 0:
        emccanon.START_SPINDLE_CLOCKWISE(8)
    if p == 1:
        emccanon.SET_SPINDLE_SPEED(9, 300)
    emccanon.SET_FEED_MODE(1, 1)
