// A robot behind its own controller, as the pins of the component robot tell it.

/** Bits, and numbers, of the component. */
const BITS = ["connected", "ready", "running", "paused", "busy", "connecting", "ended", "stopped", "enable", "hold"];
const NUMBERS = ["error", "line", "lines", "program-line", "x", "y", "z", "zero-x", "zero-y", "zero-z", "speed"];
const JOINTS = [0, 1, 2, 3, 4, 5].map((n) => `joint.${n}`);

/** Names of the pins. */
export const ROBOT_PINS = [...BITS, ...NUMBERS, ...JOINTS].map((name) => `robot.${name}`);
/** Turn of the part's X axis to that of the robot, in degrees. */
const TURN = 90;

/** Returns the state of the robot from watched values; null before they have arrived. */
export function robotOf(values) {
  const value = (name) => Object.values(values[`robot.${name}`] ?? {})[0];
  if (value("connected") === undefined) return null;
  const found = Object.fromEntries([...BITS, ...NUMBERS].map((name) => [name, value(name)]));
  const joints = JOINTS.map(value);
  const zero = ["x", "y", "z"].map((axis) => value(`zero-${axis}`));
  const point = ["x", "y", "z"].map(value);
  // The part's X points along the robot's Y, and its Y against the robot's X.
  const pose = [zero[0] - point[1], zero[1] + point[0], zero[2] + point[2]];
  return { ...found, joints, zero, point, pose };
}

/** Returns the name of the state, for texts. */
export function robotState(robot) {
  if (!robot) return "unknown";
  if (robot.stopped) return "stopped";
  if (robot.connecting) return robot.connected ? "connected" : "connecting";
  const run = ["ended", "paused", "running"].find((state) => robot[state]);
  // Neither of both: a run ends its move before it rests.
  if (run || robot.busy) return run ?? "pausing";
  return ["ready", "connected"].find((state) => robot[state]) ?? "closed";
}

/**
 * Returns a robot as the 3D view reads a machine: pose and joints, and the coordinate system of the part. Before the first
 * connection nobody knows where it is: no part zero is in the robot's base.
 */
export function asMachine(robot) {
  if (!robot?.zero.some((n) => n !== 0)) return [{}, {}];
  return [{ pose: robot.pose, joint_feedback: robot.joints }, { g5x_offset: robot.zero, rotation: TURN }];
}
