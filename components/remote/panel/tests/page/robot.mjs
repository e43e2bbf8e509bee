// A robot behind its own controller: its state from pins, and the arm that the 3D view draws.

import assert from "node:assert/strict";
import { Vector3 } from "../../page/vendor/three.module.min.js";
import { frameOf, workPose } from "../../page/src/frame.js";
import { ROBOT_PINS, asMachine, robotOf, robotState } from "../../page/src/robot/state.js";
import { kinematicsOf, patternsOf } from "../../page/src/view/kinematics.js";

/** Returns values as the server sends them. */
function values(pins) {
  const of = (name) => (/^robot\.(connected|ready|running|paused|busy|connecting|ended|stopped|enable|hold)$/.test(name) ? { bit: false } : { float: 0 });
  const all = Object.fromEntries(ROBOT_PINS.map((name) => [name, of(name)]));
  for (const [name, value] of Object.entries(pins)) all[`robot.${name}`] = typeof value === "boolean" ? { bit: value } : { float: value };
  return all;
}

assert.equal(robotOf({}), null, "before the values have arrived");
assert.equal(robotState(null), "unknown");
for (const [pins, name] of [
  [{}, "closed"], [{ busy: true, connecting: true }, "connecting"], [{ busy: true, connecting: true, connected: true }, "connected"], [{ connected: true }, "connected"], [{ connected: true, ready: true }, "ready"], [{ connected: true, running: true, busy: true }, "running"],
  [{ connected: true, busy: true }, "pausing"], [{ connected: true, busy: true, paused: true }, "paused"], [{ ended: true }, "ended"],
  [{ stopped: true, error: 2 }, "stopped"],
]) assert.equal(robotState(robotOf(values(pins))), name);

// The part's X is the robot's Y, and its Y against the robot's X.
const robot = robotOf(values({ "zero-x": -400, "zero-y": 10, "zero-z": -30, x: 42.085, y: 7.07, z: 10 }));
assert.deepEqual(robot.pose.map((n) => Number(n.toFixed(3))), [-407.07, 52.085, -20]);
const [motion, task] = asMachine(robot);
assert.deepEqual(workPose(motion, task).map((n) => Number(n.toFixed(9))), [42.085, 7.07, 10]);
assert.deepEqual(frameOf(task).zero, [-400, 10, -30]);
assert.deepEqual(asMachine(null), [{}, {}]);
assert.deepEqual(asMachine(robotOf(values({}))), [{}, {}], "before the first connection");

// The arm ends where the joints put it, with the tool pointing down.
const lengths = { A1: 120, A2: 250, A3: 0, D1: 0, D4: 250, D6: 76.5 };
const angles = [[90, -1], [-90, 1], [90, -1], [0, 1], [0, -1], [-90, 1]];
const records = [...Object.entries(lengths), ...angles.flatMap(([offset, sign], n) => [[`offset-${n}`, offset], [`sign-${n}`, sign]])]
  .map(([name, value]) => ({ name: `robot.${name}`, value: { float: value } }));
// Beside motion it is not the machine, whose kinematics are others.
assert.ok(patternsOf({ isRobot: true }).includes("robot.*") && !patternsOf({ isRobot: false }).includes("robot.*"));
const kinematics = kinematicsOf(records);
assert.equal(kinematics.name, "robot");
// Its pose is the tip already; its joints end at the flange. They tell where the tool points.
const arrived = kinematics.reported({ joint_feedback: [-90, 25.1588, -110.8242, 0, -44.017, 0] });
assert.ok(!arrived.isForward && Math.abs(arrived.axis[2] - 1) < 1e-3, `${arrived.axis}`);
for (const [joints, place] of [
  [[-90, 25.1588, -110.8242, 0, -44.017, 0], [-400, 0, -30]],
  [[-65.556, 71.3076, -10.3254, 0, -98.367, -24.444], [-550, 250, 40]],
  [[0, 0, 0, 0, 0, 0], [0, 120, 576.5]],
]) {
  const tip = new Vector3(...place);
  const parts = kinematics.parts(joints, tip);
  // What is left from the flange to the tip is shorter than the rounding of the joints.
  const [from, to] = parts.at(-1);
  const end = to.distanceTo(tip) < 1e-9 && from.distanceTo(to) < 0.02 ? from : to;
  assert.ok(end.distanceTo(tip) < 0.02, `${joints}: ${end.toArray()}`);
}
