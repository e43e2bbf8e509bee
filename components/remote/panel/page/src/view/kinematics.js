// Where the parts of machines are that have other kinematics than a joint for each axis, and where their tool is and points.

import { Vector3 } from "../../vendor/three.module.min.js";
import { jointsAlong, links, tipOf } from "./arm.js";
import { FIVE_AXIS, onPart } from "./five_axis.js";
import { IDENTITY, RADIANS, about, frame, joined, minus, ofRollPitchYaw, upward } from "./rotation.js";
import { searchJoints } from "./search.js";

/**
 * Kinematics with a picture: the parameters they need, and what they return for joints and the tip of the tool. Those that
 * are upright turn the tool about Z alone. `tip` returns the frame of the tip at these joints, `joints` those for a frame.
 */
const KINDS = {
  lineardeltakins: { reach: (p) => [[-p.R, -p.R, 0], [p.R, p.R, p.L * 2]], parts: delta, isUpright: true, joints: deltaJoints },
  scarakins: { reach: (p) => round(p.D2 + p.D4, p.D1 + Math.max(0, p.D3)), parts: scara, isUpright: true, joints: scaraJoints },
  genserkins: serial(serialLinks, /^(A|D)-/),
  pumakins: serial(pumaLinks, /^[AD]\d/),
  armkins: { reach: (p) => ball(sum(p, /^[AD]\d/)), parts: arm, tip: tipOf, joints: jointsAlong },
  // Its work volume is near its base.
  robot: { reach: (p) => ball(0.65 * sum(p, /^[AD]\d/)), parts: arm, tip: tipOf },
};

/** Arms as chains of links, whose joints for a pose are searched. */
function serial(rows, lengths) {
  const tip = (p, joints) => chain(rows(p), joints).at(-1);
  return {
    reach: (p) => ball(sum(p, lengths)),
    parts: (p, joints) => points(chain(rows(p), joints)),
    tip,
    joints: (p, goal, last) => searchJoints((joints) => tip(p, joints), goal, last),
  };
}

/** Width of a tool, in that of a link. */
const TOOL_SHARE = 0.3;
/** Returns patterns for the names of pins and parameters that tell kinematics; a robot tells them where it is the machine itself. */
export const patternsOf = ({ isRobot }) => ["*kins.*", "*_trsrn.*", "kinstype.is-*", ...(isRobot ? ["robot.*"] : [])];

/** Returns the kinematics that the names of pins and parameters tell, with their values; null for others. `info` is that of the machine. */
export function kinematicsOf(records, info = {}) {
  const value = (r) => Number(Object.values(r.value)[0]);
  for (const [name, kind] of [...Object.entries(KINDS), ...Object.entries(FIVE_AXIS)]) {
    const own = records.filter((r) => r.name.startsWith(`${name}.`));
    if (own.length === 0) continue;
    const values = Object.fromEntries(own.map((r) => [r.name.slice(name.length + 1), value(r)]));
    const types = records.filter((r) => /^kinstype\.is-\d$/.test(r.name));
    const type = types.find((r) => value(r) === 1)?.name.at(-1);
    const found = new Kinematics(name, kind, values, type, info.kinematics ?? "");
    found.types = types.map((r) => r.name);
    return found;
  }
  return null;
}

/** Kinematics of a machine as their pins have them. */
class Kinematics {
  constructor(name, kind, values, type, given) {
    Object.assign(this, { name, kind, values });
    /** Pins that tell the type in force. */
    this.types = [];
    this.isUpright = kind.isUpright === true;
    this.isFiveAxis = Boolean(kind.of);
    const own = given.includes("identityfirst") ? 1 : kind.own ?? 0;
    /** True where axes are joints: a pose is then not that of the tip. */
    this.isJoints = type !== undefined && Number(type) !== own;
    /** False where X Y Z are along the tool, or the joints of a machine whose tip is only known from a pose. */
    this.isKnown = !(kind.plane !== undefined && kind.plane === Number(type)) && !(this.isUpright && this.isJoints);
    const letters = /coordinates=(\S+)/i.exec(given)?.[1] ?? kind.letters ?? "";
    /** Letter of each joint. */
    this.letters = letters.toUpperCase();
  }

  get hasParts() {
    return Boolean(this.kind.parts);
  }

  get hasTip() {
    return Boolean(this.kind.tip);
  }

  /** True where X Y Z are joints that bring the tip round a curve, and turn it. */
  get isBent() {
    return this.isJoints && this.hasTip;
  }

  get reach() {
    return this.kind.reach(this.values);
  }

  parts(joints, tip) {
    return this.kind.parts(this.values, joints, tip);
  }

  /** Returns tip and direction of the tool, null upright, for a point less the tool's offset and the nine letters of its pose. */
  toolAt(point, letters, joints = null) {
    const { kind, values } = this;
    if (joints && kind.tip) return toolOf(kind.tip(values, joints));
    if (this.isUpright) return { tip: point, axis: null };
    if (this.isFiveAxis) {
      const { axis, tip } = onPart(kind, values, letters);
      if (!this.isJoints) return { tip: point, axis };
      // The offset is along Z, whatever the axes are.
      const place = letters.slice(0, 3);
      return { tip: minus(tip(place), minus(place, point)), axis };
    }
    if (this.isJoints) return toolOf(kind.tip(values, letters));
    return toolOf({ origin: point, turn: ofRollPitchYaw(...letters.slice(3, 6)) });
  }

  /** Returns tip and direction of the tool as the machine reports its joints; null where they do not tell. */
  reported(motion) {
    const { kind, values } = this;
    const joints = motion.joint_feedback;
    if (!joints || this.isUpright) return null;
    const offset = motion.tool_offset ?? [0, 0, 0];
    if (kind.tip) {
      const { tip, axis } = toolOf(kind.tip(values, joints));
      // A pose of joints has no place for the offset: it is on the joints already.
      return this.isJoints ? { tip, axis, isForward: true } : { tip: minus(tip, offset), axis };
    }
    const letters = [..."XYZABCUVW"].map((letter) => joints[this.letters.indexOf(letter)] ?? 0);
    const { axis, tip } = onPart(kind, values, letters);
    return { tip: minus(tip(letters.slice(0, 3)), offset), axis };
  }

  /** Returns the joints of a pose that is played, the nearest to others; null where they are not known or out of reach. */
  jointsAt({ letters, joints }, last) {
    if (joints) return joints;
    const { kind, values } = this;
    if (this.isJoints) return letters;
    if (!kind.joints) return null;
    const [x, y, z, a, b, c] = letters;
    return kind.joints(values, this.isUpright ? frame(x, y, z, 0, 0, c) : frame(x, y, z, a, b, c), last);
  }
}

/**
 * Returns how far the machine's kinematics bring the tool from where a path with joints has it, at its tip and so far up; 0 for
 * paths without joints.
 */
export function cellApart(path, kinematics, shank) {
  if (!path.joints || !path.further || !kinematics?.hasTip) return 0;
  let most = 0;
  for (const i of [0, path.count >> 1, path.count - 1]) {
    const six = (values) => [...values.subarray(6 * i, 6 * i + 6)];
    const own = kinematics.toolAt([0, 0, 0], [], six(path.joints));
    const told = toolOf({ origin: path.tip(i), turn: ofRollPitchYaw(...six(path.further).slice(0, 3)) });
    const [tips, axes] = [minus(told.tip, own.tip), minus(told.axis, own.axis)];
    for (const far of [0, shank]) most = Math.max(most, Math.hypot(...tips.map((v, k) => v + far * axes[k])));
  }
  return most;
}

/** Returns the tip and the direction of a tool in a frame whose Z points out of the arm. */
const toolOf = ({ origin, turn }) => ({ tip: origin, axis: upward(turn).map((v) => -v) });

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

/** Returns the joints of a delta: how high the carriages are. */
function deltaJoints({ R, L }, { origin: [x, y, z] }) {
  const heights = [0, 1, 2].map((i) => (90 + 120 * i) * RADIANS).map((a) => {
    const square = L * L - (x - R * Math.cos(a)) ** 2 - (y - R * Math.sin(a)) ** 2;
    return z + Math.sqrt(square);
  });
  return heights.every(Number.isFinite) ? heights : null;
}

/** Returns the joints of a scara; its elbow stays on the side where it is. */
function scaraJoints({ D1, D2, D3, D4, D5, D6 }, { origin: [x, y, z], turn }, last) {
  const yaw = Math.atan2(turn[3], turn[0]);
  const [wx, wy] = [x - D6 * Math.cos(yaw), y - D6 * Math.sin(yaw)];
  const cosine = (wx * wx + wy * wy - D2 * D2 - D4 * D4) / (2 * D2 * D4);
  if (!(Math.abs(cosine) <= 1)) return null;
  const elbow = Math.acos(cosine) * (last[1] < 0 ? -1 : 1);
  const first = Math.atan2(wy, wx) - Math.atan2(D4 * Math.sin(elbow), D2 + D4 * Math.cos(elbow));
  return [first / RADIANS, elbow / RADIANS, D1 + D3 - D5 - z, (yaw - first - elbow) / RADIANS];
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

/** An arm of armkins, or of robot, which has no frame and no tool. */
function arm(p, joints, tip) {
  const all = links(p, joints);
  // A link goes along its joint's axis, and then across it.
  const along = all.slice(0, -1).map(({ origin, turn }, i) => upward(turn).map((v, k) => origin[k] + (i === 5 ? p.D6 : [p.D1, 0, 0, p.D4, 0][i]) * v));
  const bends = all.flatMap(({ origin }, i) => (i < 6 ? [origin, along[i]] : [origin]));
  const flange = new Vector3(...all.at(-1).origin);
  return [...pairs(bends.map((v) => new Vector3(...v))), ...pairs([flange, tip]).map((part) => [...part, TOOL_SHARE])];
}

/** Returns the frames of links from the base; each joint turns about its own axis. The last is that of the tool. */
function chain(all, joints) {
  const frames = [{ origin: [0, 0, 0], turn: IDENTITY }];
  const go = (origin, turn) => frames.push(joined(frames.at(-1), { origin, turn }));
  all.forEach(({ a, alpha, d }, i) => {
    go([a, 0, 0], about(0, alpha));
    go([0, 0, d], about(2, (joints[i] ?? 0) * RADIANS));
  });
  return frames;
}

const points = (frames) => pairs(frames.map(({ origin }) => new Vector3(...origin)));
