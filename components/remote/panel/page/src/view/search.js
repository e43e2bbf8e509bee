// Joints of arms without a closed form: Newton's method from where the arm is, damped near singular places (Levenberg and
// Marquardt; Buss, Introduction to Inverse Kinematics, 2004).

import { times, transposed } from "./rotation.js";

/** Most steps, and the largest change of a joint in one, in degrees. */
const [STEPS, MOST] = [60, 15];
/** Step of a joint, in degrees, by which the change of the tip is measured. */
const LITTLE = 1e-4;
/** Distance of the tip, and angle in radians, at which it is there. */
const [NEAR, STRAIGHT] = [1e-6, 1e-8];

/** Returns the joints near others that bring the tip to a frame; null where the search does not get there. `tipAt` returns the frame of the tip at joints. */
export function searchJoints(tipAt, goal, last) {
  let joints = [0, 1, 2, 3, 4, 5].map((i) => last[i] ?? 0);
  for (let n = 0; n < STEPS; n++) {
    const at = tipAt(joints);
    const error = apart(at, goal);
    if (Math.hypot(...error.slice(0, 3)) < NEAR && Math.hypot(...error.slice(3)) < STRAIGHT) return joints;
    const columns = joints.map((_, i) => {
      const other = tipAt(joints.map((v, k) => (k === i ? v + LITTLE : v)));
      return apart(at, other).map((v) => v / LITTLE);
    });
    const step = damped(columns, error);
    const most = Math.max(...step.map(Math.abs));
    if (!(most > 0) || !Number.isFinite(most)) return null;
    const scale = Math.min(1, MOST / most);
    joints = joints.map((v, i) => v + scale * step[i]);
  }
  return null;
}

/** Returns the way from one frame to another, and the rotation vector. */
function apart(from, to) {
  const m = times(to.turn, transposed(from.turn));
  const twice = [m[7] - m[5], m[2] - m[6], m[3] - m[1]];
  const sine = Math.hypot(...twice) / 2;
  const angle = Math.atan2(sine, (m[0] + m[4] + m[8] - 1) / 2);
  const scale = sine > 1e-9 ? angle / (2 * sine) : 0.5;
  return [...to.origin.map((v, i) => v - from.origin[i]), ...twice.map((v) => v * scale)];
}

/** Returns the least squares of columns against an error, with a little of each unknown. */
function damped(columns, error) {
  const size = columns.length;
  const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
  // A length of the arm and an angle count alike.
  const reach = Math.max(1e-9, ...columns.map((c) => Math.hypot(...c.slice(0, 3)))) / (Math.PI / 180);
  const weigh = (c) => c.map((v, i) => (i < 3 ? v : v * reach));
  const [rows, goal] = [columns.map(weigh), weigh(error)];
  const all = rows.map((a, i) => [...rows.map((b, k) => dot(a, b) * (i === k ? 1 + 1e-12 : 1)), dot(a, goal)]);
  const floor = 1e-10 * Math.max(...all.map((row, i) => row[i]));
  all.forEach((row, i) => { row[i] += floor; });
  for (let i = 0; i < size; i++) {
    const pivot = all.slice(i).reduce((best, row, k) => (Math.abs(row[i]) > Math.abs(all[best][i]) ? i + k : best), i);
    [all[i], all[pivot]] = [all[pivot], all[i]];
    for (let k = i + 1; k < size; k++) {
      const share = all[k][i] / all[i][i];
      for (let j = i; j <= size; j++) all[k][j] -= share * all[i][j];
    }
  }
  const out = new Array(size).fill(0);
  for (let i = size - 1; i >= 0; i--) {
    let sum = all[i][size];
    for (let j = i + 1; j < size; j++) sum -= all[i][j] * out[j];
    out[i] = sum / all[i][i];
  }
  return out;
}
