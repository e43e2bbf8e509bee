// Stock that is cut by a program which is played, in slices, or by the machine, without anything of the browser.

import { MOTION } from "../operator/states.js";
import { RAPID } from "./path.js";

/** A program that is played: the tool's place after some of the path's time, and what its rapid moves have cut. */
export class Player {
  /**
   * `times` has the minutes at which each point of the path is reached, `tools` returns the tool of a number, `stock` may
   * be null, and `frame` is that of the stock. Throws an error for a path without moves.
   */
  constructor({ path, times, tools, stock, frame }) {
    if (!(path.count > 1)) throw new RangeError("nothing moves");
    Object.assign(this, { path, times, tools, stock, frame });
    this.time = 0;
    /** Point that the tool goes to. */
    this.next = 1;
    /** Numbers of the points where rapid moves end that have cut the stock. */
    this.rapids = [];
    this.tip = path.tip(0, 1);
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
    const { path, times } = this;
    const until = this.time + minutes;
    let left = work;
    while (!this.isDone && left > 0) {
      const i = this.next;
      const end = path.tip(i);
      const isReached = !(until < times[i]);
      // Between two points the tool is where the time says.
      const rest = times[i] - this.time;
      const part = isReached || !(rest > 0) ? 1 : Math.max(0, until - this.time) / rest;
      const to = part === 1 ? end : this.tip.map((v, axis) => v + part * (end[axis] - v));
      left -= 1 + this.move(i, to);
      this.tip = to;
      if (!isReached) {
        this.time = until;
        return;
      }
      this.time = Math.max(this.time, times[i]);
      this.next += 1;
      // A tool of another length is no motion of the tip.
      if (!this.isDone) this.tip = path.tip(i, i + 1);
    }
  }

  /** Cuts with the tool on its way, and returns how much work that was. */
  move(i, to) {
    const { path, stock, frame, tip } = this;
    if (!stock) return 0;
    const isRapid = path.kinds[i] === RAPID;
    const volume = stock.cut(this.tools(path.tools[i]), frame.part(tip), frame.part(to), isRapid);
    if (isRapid && volume > 0 && this.rapids.at(-1) !== i) this.rapids.push(i);
    return stock.work;
  }
}

/** The machine as its reports show it: between two, its tool is taken to go straight. */
export class Carver {
  constructor(stock, frame) {
    Object.assign(this, { stock, frame });
    /** Number of rapid moves that have cut. */
    this.rapids = 0;
    this.tip = null;
    this.segment = 0;
  }

  /** Forgets where the tool is: its way to the next report is not known. */
  lose() {
    this.tip = null;
  }

  /** Cuts with this tool as far as a report of the motion says. */
  report(motion, tool) {
    const pose = motion.pose_feedback ?? motion.pose;
    const from = this.tip;
    this.tip = pose ? this.frame.part([0, 1, 2].map((i) => pose[i] - (motion.tool_offset?.[i] ?? 0))) : null;
    if (!from || !this.tip || this.tip.every((v, i) => v === from[i])) return;
    const isRapid = motion.motion_type === MOTION.rapid;
    const removed = this.stock.cut(tool, from, this.tip, isRapid);
    if (removed === 0 || !isRapid || this.segment === motion.segment) return;
    this.rapids += 1;
    this.segment = motion.segment;
  }
}
