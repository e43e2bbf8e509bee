// Stock that is cut by a program which is played, in slices, or by the machine, without anything of the browser.

import { MOTION } from "../operator/states.js";
import { RAPID } from "./path.js";
import { dot } from "./sweep.js";

/**
 * Largest change of a tool's direction in one cut, in radians. With it, the tool is in the middle of the change: a cell that is
 * as far from the tip as the stock is wide, some 200 cells, is off by less than half a cell.
 */
const TURN = (0.25 * Math.PI) / 180;
/** Cuts between two reports at most: the next report waits for them. */
const LIVE_TURNS = 48;
/** Work of a step without and with kinematics, in cells. */
const [STEP_WORK, POSE_WORK] = [1, 20];
/** Change of an axis, in degrees, between two looks at where the tool points. */
const LOOK = 5;
/** Change of an arm's joints, in degrees, in one cut: an arm of 1 m leaves the straight way by less than 0.04 mm. */
const BEND = 1;

/** A program that is played: the tool's place after some of the path's time, and what its rapid moves have cut. */
export class Player {
  /**
   * `times` has the minutes at which each point of the path is reached, `tools` returns the tool of a number, `stock` may
   * be null, and `frame` is that of the stock. `poser` tells the tip and the direction of the tool at places of the path, or is
   * null where the tool is upright. Throws an error for a path without moves.
   */
  constructor({ path, times, tools, stock, frame, poser = null }) {
    if (!(path.count > 1)) throw new RangeError("nothing moves");
    Object.assign(this, { path, times, tools, stock, frame, poser });
    this.time = 0;
    /** Point that the tool goes to. */
    this.next = 1;
    /** Numbers of the points where rapid moves end that have cut the stock. */
    this.rapids = [];
    /** Number of these moves: a planned one ends at several points. */
    this.rapidMoves = 0;
    this.begin(0, 1);
  }

  get isDone() {
    return this.next >= this.path.count;
  }

  /** Part of the time that has passed, from 0 to 1. */
  get share() {
    const total = this.times[this.path.count - 1];
    return this.isDone || !(total > 0) ? 1 : Math.min(1, this.time / total);
  }

  /** Tool in the spindle. */
  get tool() {
    return this.tools(this.path.tools[Math.min(this.next, this.path.count - 1)]);
  }

  /** Plays on for some minutes, or as far as `work` cells allow: no call takes long. */
  play(minutes, work) {
    const { times } = this;
    const until = this.time + minutes;
    let left = work;
    while (!this.isDone && left > 0) {
      const i = this.next;
      const isReached = !(until < times[i]);
      // Between two points the tool is where the time says.
      const rest = times[i] - this.time;
      const byTime = isReached || !(rest > 0) ? 1 : Math.max(0, until - this.time) / rest;
      const part = Math.min(byTime, 1 / this.turns);
      left -= (this.poser ? POSE_WORK : STEP_WORK) + this.move(i, part);
      if (!isReached && part === byTime) {
        this.time = until;
        return;
      }
      if (part < 1) {
        if (rest > 0) this.time += part * rest;
        this.turns -= 1;
        continue;
      }
      this.time = Math.max(this.time, times[i]);
      this.next += 1;
      // A tool of another length is no motion of the tip.
      if (!this.isDone) left -= this.begin(i, i + 1);
    }
  }

  /** Puts the tool to a point of the path, with the tool and the way of another, and returns how much work that was. */
  begin(i, as) {
    const { path, poser } = this;
    this.at = poser ? poser.place(i, as) : null;
    this.pose = poser ? poser.pose(this.at) : null;
    this.tip = poser ? this.pose.tip : path.tip(i, as);
    this.turns = poser ? poser.turns(this.at, poser.place(as, as)) : 1;
    return poser ? POSE_WORK * poser.looks : 0;
  }

  /** Goes a part of what is left of the way to a point, cuts on it, and returns how much work that was. */
  move(i, part) {
    const { path, poser, tip, at } = this;
    if (!poser) {
      const end = path.tip(i);
      this.tip = part === 1 ? end : tip.map((v, axis) => v + part * (end[axis] - v));
      return this.cut(i, tip, this.tip, null);
    }
    const end = poser.place(i, i);
    this.at = part === 1 ? end : mix(at, end, part);
    this.pose = poser.pose(this.at);
    this.tip = this.pose.tip;
    return this.cut(i, tip, this.tip, poser.isFixed ? this.pose.axis : poser.pose(mix(at, this.at, 0.5)).axis);
  }

  cut(i, from, to, axis) {
    const { path, stock, frame } = this;
    if (!stock) return 0;
    const isRapid = path.kinds[i] === RAPID;
    const volume = stock.cut(this.tools(path.tools[i]), frame.part(from), frame.part(to), isRapid, axis && frame.vector(axis));
    const last = this.rapids.at(-1);
    if (isRapid && volume > 0 && last !== i) {
      if (last !== i - 1 || path.lines[last] !== path.lines[i]) this.rapidMoves += 1;
      this.rapids.push(i);
    }
    return stock.work;
  }
}

/**
 * Where the tool of a path is and points: `toolAt(point, letters, joints)` returns tip and direction for the place of the path less
 * the tool's offset, the nine letters of the pose, and six joints where the path has them. Letters that the path does not move stay
 * as in `still`. `isBent` is true where X Y Z are joints of an arm: the tip then goes along a curve.
 */
export class Poser {
  constructor(path, toolAt, still = [], isBent = false) {
    /** Looks at poses that the last way took. */
    this.looks = 0;
    Object.assign(this, { path, toolAt, isBent });
    this.still = Array.from({ length: 9 }, (_, i) => still[i] ?? 0);
    /** True where the tool keeps its direction. */
    this.isFixed = !path.further && !path.joints && !isBent;
  }

  /** Returns the numbers of a point, with the tool of another: X Y Z of the tip, the nine letters, the joints. */
  place(i, as) {
    const { path, still } = this;
    const numbers = [...path.tip(i, as), ...still];
    for (const axis of [0, 1, 2]) numbers[3 + axis] = path.points[3 * i + axis] + path.origin[axis];
    for (let k = 0; k < 6; k++) {
      if (path.further && path.others.includes("ABCUVW"[k])) numbers[6 + k] = path.further[6 * i + k];
      if (path.joints) numbers.push(path.joints[6 * i + k]);
    }
    return numbers;
  }

  /** Returns tip, direction, letters and joints at such numbers. */
  pose(numbers) {
    const letters = numbers.slice(3, 12);
    const joints = numbers.length > 12 ? numbers.slice(12) : null;
    return { letters, joints, ...this.toolAt(numbers.slice(0, 3), letters, joints) };
  }

  /** Returns in how many parts of equal length a way is cut. */
  turns(from, to) {
    this.looks = 0;
    if (this.isFixed) return 1;
    let [most, bend] = [0, 0];
    for (let k = this.isBent ? 3 : 6; k < from.length; k++) {
      const far = Math.abs(to[k] - from[k]);
      most = Math.max(most, far);
      if (this.isBent && k < 9) bend += far;
    }
    if (!(most > 0) || !Number.isFinite(most)) return 1;
    const looks = Math.min(1000, Math.ceil(most / LOOK));
    this.looks = looks;
    let [sum, last] = [0, this.pose(from).axis];
    for (let n = 1; n <= looks; n++) {
      const { axis } = this.pose(mix(from, to, n / looks));
      sum += between(last, axis);
      last = axis;
    }
    return Math.max(1, Math.ceil(sum / TURN), Math.ceil(bend / BEND));
  }
}

/** The machine as its reports show it: between two, its tool is taken to go straight and to turn evenly. */
export class Carver {
  /** `poseOf` returns the tip and the direction of the tool that a report says; without it the tool is upright. */
  constructor(stock, frame, poseOf = null) {
    Object.assign(this, { stock, frame, poseOf });
    /** Number of rapid moves that have cut. */
    this.rapids = 0;
    this.pose = null;
    this.segment = 0;
  }

  /** Forgets where the tool is: its way to the next report is not known. */
  lose() {
    this.pose = null;
  }

  /** Cuts with this tool as far as a report of the motion says. */
  report(motion, tool) {
    const from = this.pose;
    this.pose = this.posed(motion);
    if (!from || !this.pose) return;
    const to = this.pose;
    const angle = from.axis ? between(from.axis, to.axis) : 0;
    if (angle === 0 && to.tip.every((v, i) => v === from.tip[i])) return;
    const isRapid = motion.motion_type === MOTION.rapid;
    const count = Math.max(1, Math.min(LIVE_TURNS, Math.ceil(angle / TURN)));
    let removed = 0;
    for (let n = 0; n < count; n++) {
      const [a, b] = [n, n + 1].map((k) => mix(from.tip, to.tip, k / count));
      const axis = from.axis && unit(mix(from.axis, to.axis, (n + 0.5) / count));
      removed += this.stock.cut(tool, a, b, isRapid, axis);
    }
    if (removed === 0 || !isRapid || this.segment === motion.segment) return;
    this.rapids += 1;
    this.segment = motion.segment;
  }

  /** Returns tip and direction in the frame of the stock; null where a report has none. */
  posed(motion) {
    const pose = motion.pose_feedback ?? motion.pose;
    if (!pose) return null;
    const { tip, axis } = this.poseOf ? this.poseOf(motion) : { tip: tipOf(motion), axis: null };
    return { tip: this.frame.part(tip), axis: axis && this.frame.vector(axis) };
  }
}

/** Returns the tip of the tool that a report says: the machine's point less the tool's offset. */
export function tipOf(motion) {
  const pose = motion.pose_feedback ?? motion.pose;
  return [0, 1, 2].map((i) => pose[i] - (motion.tool_offset?.[i] ?? 0));
}

const mix = (from, to, part) => from.map((v, i) => v + part * (to[i] - v));

/** Returns the angle between two directions; 0 between upright tools, which have none. */
function between(a, b) {
  if (!a || !b) return 0;
  // Near 0 the cosine says nothing.
  const apart = a.map((v, i) => b[i] - v);
  return 2 * Math.asin(Math.min(1, Math.sqrt(dot(apart, apart)) / 2));
}

/** Returns a vector at unit length; opposite directions have upright in between. */
function unit(v) {
  const size = Math.sqrt(dot(v, v));
  return size > 1e-9 ? v.map((x) => x / size) : [0, 0, 1];
}
