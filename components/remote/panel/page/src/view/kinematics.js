// Where the parts of machines are that have other kinematics than a joint for each axis.

import { Euler, Matrix4, Vector3 } from "../../vendor/three.module.min.js";

const RADIANS = Math.PI / 180;

/**
 * Kinematics with a picture: the parameters they need, and what they return for joints and the tip of the tool. Those that
 * are upright turn the tool about Z alone.
 */
const KINDS = {
  lineardeltakins: { reach: (p) => [[-p.R, -p.R, 0], [p.R, p.R, p.L * 2]], parts: delta, isUpright: true },
  scarakins: { reach: (p) => round(p.D2 + p.D4, p.D1 + Math.max(0, p.D3)), parts: scara, isUpright: true },
  genserkins: { reach: (p) => ball(sum(p, /^(A|D)-/)), parts: (p, joints) => chain(serialLinks(p), joints) },
  pumakins: { reach: (p) => ball(sum(p, /^[AD]\d/)), parts: (p, joints) => chain(pumaLinks(p), joints) },
  armkins: { reach: (p) => ball(sum(p, /^[AD]\d/)), parts: arm },
  // Its work volume is near its base.
  robot: { reach: (p) => ball(0.65 * sum(p, /^[AD]\d/)), parts: arm },
};

/** Returns the kinematics that the names of pins and parameters tell, with their values; null for others. */
export function kinematicsOf(records) {
  for (const [name, kind] of Object.entries(KINDS)) {
    const own = records.filter((r) => r.name.startsWith(`${name}.`));
    if (own.length === 0) continue;
    const values = Object.fromEntries(own.map((r) => [r.name.slice(name.length + 1), Number(Object.values(r.value)[0])]));
    return { name, isUpright: kind.isUpright === true, reach: kind.reach(values), parts: (joints, tip) => kind.parts(values, joints, tip) };
  }
  return null;
}

const sum = (p, names) => Object.entries(p).reduce((all, [name, value]) => all + (names.test(name) ? Math.abs(value) : 0), 0);
const round = (r, height) => [[-r, -r, 0], [r, r, height]];
const ball = (r) => [[-r, -r, -0.4 * r], [r, r, r]];

/** Three upright rails on a circle, a carriage on each, a rod from each to the tool. */
function delta({ R, L }, joints, tip) {
  const rails = [0, 1, 2].map((i) => (90 + 120 * i) * RADIANS).map((a) => new Vector3(R * Math.cos(a), R * Math.sin(a), 0));
  const high = Math.max(...joints.slice(0, 3)) + 0.1 * L;
  return rails.flatMap((foot, i) => {
    const carriage = foot.clone().setZ(joints[i]);
    return [[foot, foot.clone().setZ(high)], [carriage, tip]];
  });
}

/** A column, two links that turn about upright axes, a spindle down to the tool. */
function scara({ D1, D2, D3, D4 }, joints, tip) {
  const [a, b] = [joints[0] * RADIANS, (joints[0] + joints[1]) * RADIANS];
  const elbow = new Vector3(D2 * Math.cos(a), D2 * Math.sin(a), D1);
  const above = elbow.clone().setZ(D1 + D3);
  const wrist = new Vector3(elbow.x + D4 * Math.cos(b), elbow.y + D4 * Math.sin(b), D1 + D3);
  const low = wrist.clone().setZ(tip.z);
  return pairs([new Vector3(), new Vector3(0, 0, D1), elbow, above, wrist, low, tip]);
}

/** Joins neighbours that are apart. */
function pairs(points) {
  return points.slice(1).map((point, i) => [points[i], point]).filter(([from, to]) => from.distanceTo(to) > 1e-9);
}

/** Links of genserkins: distance across and angle to the axis before, distance along the own axis. */
function serialLinks(p) {
  return [0, 1, 2, 3, 4, 5].map((i) => ({ a: p[`A-${i}`], alpha: p[`ALPHA-${i}`], d: p[`D-${i}`] }));
}

/** Links of a puma: shoulder, elbow, and a wrist whose axes meet. */
function pumaLinks({ A2, A3, D3, D4, D6 }) {
  const quarter = Math.PI / 2;
  const rows = [[0, 0, 0], [0, -quarter, 0], [A2, 0, D3], [A3, -quarter, D4], [0, quarter, 0], [0, -quarter, D6]];
  return rows.map(([a, alpha, d]) => ({ a, alpha, d }));
}

/** An arm of armkins, or of robot, which has no frame: joints with directions and offsets, with a tool. */
function arm(p, joints, tip) {
  const quarter = Math.PI / 2;
  const frame = new Matrix4().makeRotationFromEuler(new Euler(...["a", "b", "c"].map((k) => (p[`frame.${k}`] ?? 0) * RADIANS), "ZYX"));
  frame.setPosition(p["frame.x"] ?? 0, p["frame.y"] ?? 0, p["frame.z"] ?? 0);
  const at = frame.invert();
  const points = [new Vector3().setFromMatrixPosition(at)];
  const links = [[p.A1, p.D1, -quarter], [p.A2, 0, 0], [p.A3, 0, quarter], [0, p.D4, -quarter], [0, 0, quarter], [0, p.D6, 0]];
  links.forEach(([a, d, alpha], i) => {
    const angle = (p[`offset-${i}`] + p[`sign-${i}`] * (joints[i] ?? 0)) * RADIANS;
    at.multiply(new Matrix4().makeRotationZ(angle));
    points.push(new Vector3(0, 0, d).applyMatrix4(at));
    at.multiply(new Matrix4().makeTranslation(a, 0, d));
    points.push(new Vector3().setFromMatrixPosition(at));
    at.multiply(new Matrix4().makeRotationX(alpha));
  });
  return pairs([...points, tip]);
}

/** Follows links from the base; each joint turns about its own axis. */
function chain(links, joints) {
  const at = new Matrix4();
  const points = [new Vector3().setFromMatrixPosition(at)];
  links.forEach(({ a, alpha, d }, i) => {
    at.multiply(new Matrix4().makeRotationX(alpha));
    at.multiply(new Matrix4().makeTranslation(a, 0, 0));
    points.push(new Vector3().setFromMatrixPosition(at));
    at.multiply(new Matrix4().makeRotationZ((joints[i] ?? 0) * RADIANS));
    at.multiply(new Matrix4().makeTranslation(0, 0, d));
    points.push(new Vector3().setFromMatrixPosition(at));
  });
  return pairs(points);
}
