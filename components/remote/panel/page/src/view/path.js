// The path of a program, as the server computes it: FERPATH1 in API.md.

import { Color } from "../../vendor/three.module.min.js";
import { word } from "./raster.js";

const MAGIC = "FERPATH1";
const HEADER_BYTES = 64;
/** Points whose times are found at once. */
const TIMES = 131_072;
/** Bits of points that have further axes and joints. */
const [FURTHER, JOINTS] = [1 << 8, 1 << 9];
/** Kind of rapid moves; cuts have higher ones. */
export const RAPID = 1;
/** Rapids show what is behind them. */
const RAPID_ALPHA = 140;
/** The programmed path shows the planned one. */
const FAINT_ALPHA = 130;
/** Most tools that have colours of their own. */
const TOOL_COLOURS = [0x3fb1ff, 0x7ed957, 0xffb020, 0xc78bff, 0xff7b7b, 0x4fd6c8, 0xf58fd0, 0xd9d957];

/** Points of a path in machine units. */
export class Path {
  /** Reads the bytes of the server; throws an error if they are none. */
  constructor(buffer) {
    const magic = new TextDecoder().decode(new Uint8Array(buffer, 0, Math.min(8, buffer.byteLength)));
    if (magic !== MAGIC) throw new Error(`not a path: ${magic}`);
    const view = new DataView(buffer);
    const n = view.getUint32(8, true);
    const flags = view.getUint32(12, true);
    const f64 = (at) => view.getFloat64(at, true);
    const f32 = (at) => view.getFloat32(at, true);
    this.count = n;
    this.isComplete = (flags & 1) !== 0;
    this.isReduced = (flags & 2) !== 0;
    this.origin = [f64(16), f64(24), f64(32)];
    this.low = [f32(40), f32(44), f32(48)].map((v, i) => v + this.origin[i]);
    this.high = [f32(52), f32(56), f32(60)].map((v, i) => v + this.origin[i]);
    let at = HEADER_BYTES;
    const part = (type, count) => {
      const values = new type(buffer, at, count);
      at += values.byteLength;
      return values;
    };
    this.points = part(Float32Array, 3 * n);
    this.lines = part(Uint32Array, n);
    this.feeds = part(Float32Array, n);
    this.tools = part(Uint16Array, n);
    this.kinds = part(Uint8Array, n);
    /** Letters of the axes beside X Y Z that move. */
    this.others = [..."ABCUVW"].filter((_, bit) => (flags >> (bit + 2)) & 1).join("");
    at = 4 * Math.ceil(at / 4);
    /** A B C U V W of each point, where any of them moves, and six joints, where an arm's are chosen. */
    this.further = flags & FURTHER ? part(Float32Array, 6 * n) : null;
    this.joints = flags & JOINTS ? part(Float32Array, 6 * n) : null;
    const changes = [];
    for (; at + 16 <= buffer.byteLength; at += 16) {
      changes.push({ first: view.getUint32(at, true), offset: [f32(at + 4), f32(at + 8), f32(at + 12)] });
    }
    this.lengths = toolLengths(this, changes);
    this.lengthAt = 0;
  }

  /** Returns the tip of the tool at a point, in `out`; with `as`, that of the tool which is there at another point. */
  tip(i, as = i, out = [0, 0, 0]) {
    const { points, origin } = this;
    const offset = this.lengths.length > 0 ? this.offset(as) : null;
    for (let axis = 0; axis < 3; axis++) out[axis] = points[3 * i + axis] + origin[axis] - (offset ? offset[axis] : 0);
    return out;
  }

  /** Returns how far the tip is from the point that the path has; null where both are the same. */
  offset(i) {
    const { lengths } = this;
    if (lengths.length === 0) return null;
    // Mostly it is the one of the last question.
    if (lengths[this.lengthAt].first > i) this.lengthAt = 0;
    while (this.lengthAt + 1 < lengths.length && lengths[this.lengthAt + 1].first <= i) this.lengthAt += 1;
    return lengths[this.lengthAt].offset;
  }

  /** Returns the time in minutes at which each point is reached; `rapid` is the feed of rapids. */
  timeline(rapid) {
    if (!this.times) {
      const all = new Float64Array(this.count);
      addTimes(this, rapid, all, 1, this.count);
      this.times = all;
    }
    return this.times;
  }

  /** Returns the same as `timeline`, but found in parts: in between, `rest` may let others work. */
  async timelineInParts(rapid, rest) {
    const all = this.times ?? new Float64Array(this.count);
    for (let first = 1; first < this.count && !this.times; first += TIMES) {
      addTimes(this, rapid, all, first, Math.min(this.count, first + TIMES));
      await rest();
    }
    this.times ??= all;
    return this.times;
  }

  /** Returns the share of the path's time that lies before a line of the program; `rapid` is the feed of rapids. */
  share(line, rapid) {
    const all = this.timeline(rapid);
    const total = all.at(-1) ?? 0;
    if (total === 0) return 0;
    let at = 0;
    while (at < this.count - 1 && this.lines[at] < line) at++;
    return all[at] / total;
  }
}

/**
 * Returns how long the tools are, each from a point on. A tool keeps its length while its offset is not in force (G49,
 * or before its G43): then it has the one that is in force later or was before. Empty where no offset ever is.
 */
function toolLengths({ tools, count }, changes) {
  if (changes.length === 0) return [];
  const runs = [];
  let offset = null;
  for (let i = 0, next = 0; i < count; i++) {
    const isOther = i === 0 || tools[i] !== tools[i - 1];
    const isChange = next < changes.length && changes[next].first === i;
    if (isChange) offset = changes[next++].offset.some((v) => v !== 0) ? changes[next - 1].offset : null;
    if (isOther || isChange) runs.push({ first: i, offset, tool: tools[i] });
  }
  const fill = (run, near) => {
    if (!run.offset && near?.tool === run.tool) run.offset = near.offset;
  };
  runs.forEach((run, i) => fill(run, runs[i - 1]));
  for (let i = runs.length - 2; i >= 0; i--) fill(runs[i], runs[i + 1]);
  return runs;
}

/** Finds the times in minutes at which some points are reached, without accelerations. */
function addTimes({ points, feeds, further }, rapid, all, first, end) {
  for (let i = first; i < end; i++) {
    const p = 3 * i;
    const [x, y, z] = [points[p] - points[p - 3], points[p + 1] - points[p - 2], points[p + 2] - points[p - 1]];
    // Math.hypot takes ten times as long.
    const long = Math.sqrt(x * x + y * y + z * z);
    all[i] = all[i - 1] + (long === 0 && further ? turn(further, i) : long) / (feeds[i] > 0 ? feeds[i] : rapid);
  }
}

/** Returns how far the axes beside X Y Z go to a point: the feed is theirs where no other moves. */
function turn(further, i) {
  let sum = 0;
  for (let k = 6 * i; k < 6 * i + 6; k++) sum += (further[k] - further[k - 6]) ** 2;
  return Math.sqrt(sum);
}

/** Returns the lines of a path for a raster: rapids have their colour, cuts that of their feed or tool; a faint one has one colour. */
export function pathLines(path, { rapid, colourBy, faint }) {
  const { points, origin, kinds, count } = path;
  if (faint) return { points, origin, kinds, colours: new Uint32Array(count).fill(word(faint, FAINT_ALPHA)) };
  const colour = colourBy === "feed" ? byFeed(path) : byTool(path);
  const isRapid = word(rapid, RAPID_ALPHA);
  const colours = new Uint32Array(count);
  for (let i = 0; i < count; i++) colours[i] = kinds[i] === RAPID ? isRapid : colour(i);
  return { points, origin, kinds, colours };
}

/** Returns the function that colours points by their tool. */
function byTool({ tools }) {
  const table = TOOL_COLOURS.map((colour) => word(colour));
  return (i) => table[tools[i] % table.length];
}

/** Returns the function that colours points by their feed: blue is slow, red is the fastest of the program. */
function byFeed({ feeds, count }) {
  let most = 1e-9;
  for (let i = 0; i < count; i++) most = Math.max(most, feeds[i]);
  const hue = (i) => new Color().setHSL(0.66 - (0.66 * i) / 255, 0.9, 0.6).getHex();
  const table = Array.from({ length: 256 }, (_, i) => word(hue(i)));
  return (i) => table[Math.round((255 * Math.max(0, feeds[i])) / most)];
}
