// Stock as columns of material, cut by tools that move, without anything of the browser.
//
// Upright tools leave one piece of material in a column, from the floor up to a height that says all. Tilted ones can cut
// below: only such a column has a list of its pieces.

import { RAPID } from "./path.js";
import { Sweep, shadow, spanOf } from "./sweep.js";

/** Number of cells of a field at most. */
export const MAX_CELLS = 40_000;
/** What has cut a cell. */
export const [UNCUT, CUT, CRASHED] = [0, 1, 2];
/** Depth, in sizes of a cell, below which a rapid move only touches: points are rounded. */
const TOUCH = 1e-2;
/** Thickness, in sizes of a cell, of a piece that is too thin to stay. */
const THIN = 1e-3;
/** Number of pieces of a column at most: then the thinnest goes. */
const MAX_PIECES = 64;
/** Number of pieces of all columns that have several at most, in columns of the field: then a column that is cut again loses its thinnest. */
const SHARE_PIECES = 4;
/** Cosine of the angle between a tool and the upright, from which on it is upright. */
const UPRIGHT = 1 - 1e-12;
/** Points of a path between two looks at the time, without and with kinematics. */
const [LOOK, POSE_LOOK] = [65_536, 2048];
/** Work of a cell that a tilted tool passes, in cells of an upright one. */
const TILTED_WORK = 4;

/** A box of material between two points. */
export class Dexels {
  /** Throws an error where the box is none. */
  constructor(low, high, most = MAX_CELLS) {
    const size = high.map((v, i) => v - low[i]);
    if (size.length !== 3 || !size.every((v) => v > 0 && Number.isFinite(v))) throw new RangeError("no box");
    [this.low, this.high] = [[...low], [...high]];
    // A long and narrow box has one row of cells at least.
    const cell = Math.max(Math.sqrt((size[0] * size[1]) / most), Math.max(size[0], size[1]) / most);
    this.nx = Math.min(most, Math.max(1, Math.floor(size[0] / cell)));
    this.ny = Math.min(Math.floor(most / this.nx), Math.max(1, Math.floor(size[1] / cell)));
    this.dx = size[0] / this.nx;
    this.dy = size[1] / this.ny;
    this.heights = new Float64Array(this.nx * this.ny).fill(high[2]);
    this.marks = new Uint8Array(this.nx * this.ny);
    /** Columns of which the height does not say all, and their pieces: lower and upper ends in turn, from below. */
    this.isSplit = new Uint8Array(this.nx * this.ny);
    this.split = new Map();
    /** Number of pieces of all those columns. */
    this.pieceCount = 0;
    /** Volume that was removed. */
    this.removed = 0;
    this.settled();
  }

  /** Size of a cell: the longer side. */
  get cell() {
    return Math.max(this.dx, this.dy);
  }

  /** Forgets which rows have changed. */
  settled() {
    this.changed = [this.ny, -1];
  }

  /** Returns the pieces of a column: lower and upper ends in turn, from below. */
  pieces(at) {
    if (this.isSplit[at] !== 0) return this.split.get(at);
    return this.heights[at] > this.low[2] ? [this.low[2], this.heights[at]] : [];
  }

  /**
   * Cuts with a tool whose tip moves straight from one point to another; `tool` has `radius` and `isBall`, `axis` is the
   * unit vector from the tip to the holder, null upright. Returns the volume that this removes, and in `work` how many
   * cells it has looked at.
   *
   * A rapid move is taken to be half a cell narrower: it does not cut what it only slides along.
   */
  cut(tool, from, to, isRapid = false, axis = null) {
    this.work = 0;
    const reach = isRapid ? tool.radius - this.cell / 2 : tool.radius;
    const isKnown = [...from, ...to, ...(axis ?? [])].every(Number.isFinite) && reach > 0 && Number.isFinite(tool.radius);
    if (!isKnown) return 0;
    if (axis && axis[2] < UPRIGHT) return this.cutTilted(tool, reach, from, to, axis, isRapid);
    return this.cutUpright(tool, reach, from, to, isRapid);
  }

  cutUpright({ radius, isBall }, reach, from, to, isRapid) {
    const [x, y, z] = from;
    const [ax, ay, az] = [to[0] - x, to[1] - y, to[2] - z];
    const long = Math.sqrt(ax * ax + ay * ay);
    // Straight down or up there is no direction.
    const [ux, uy, slope] = long > 0 ? [ax / long, ay / long, az / long] : [1, 0, 0];
    const end = long > 0 ? long : 0;
    const bottom = long > 0 ? z : Math.min(z, z + az);
    const touch = isRapid ? TOUCH * this.cell : 0;
    const mark = isRapid ? CRASHED : CUT;
    const [lowX, lowY, floor] = this.low;
    const { dx, dy, nx, ny, heights, isSplit } = this;
    if (Math.min(z, z + az) >= this.high[2]) return 0;
    const first = Math.max(0, Math.ceil((Math.min(y, y + ay) - reach - lowY) / dy - 0.5));
    const last = Math.min(ny - 1, Math.floor((Math.max(y, y + ay) + reach - lowY) / dy - 0.5));
    let volume = 0;
    for (let row = first; row <= last; row++) {
      const cy = lowY + (row + 0.5) * dy - y;
      const [left, right] = span(ax, ay, cy, reach);
      const begin = Math.max(0, Math.ceil((x + left - reach - lowX) / dx - 0.5));
      const stop = Math.min(nx - 1, Math.floor((x + right + reach - lowX) / dx - 0.5));
      let lowered = 0;
      for (let column = begin; column <= stop; column++) {
        const cx = lowX + (column + 0.5) * dx - x;
        const across = cy * ux - cx * uy;
        const along = cx * ux + cy * uy;
        const half2 = reach * reach - across * across;
        if (half2 < 0) continue;
        // The tool is over the cell while its way is within `half` of the place beside the cell.
        const half = Math.sqrt(half2);
        const least = Math.max(-half, -along);
        const most = Math.min(half, end - along);
        if (least > most) continue;
        let height;
        if (isBall) {
          const ball2 = radius * radius - across * across;
          const lowest = -slope * Math.sqrt(ball2 / (1 + slope * slope));
          const w = Math.min(most, Math.max(least, lowest));
          height = bottom + slope * (along + w) + radius - Math.sqrt(Math.max(0, ball2 - w * w));
        } else {
          height = bottom + slope * (along + (slope > 0 ? least : most));
        }
        height = Math.max(height, floor);
        const at = row * nx + column;
        if (isSplit[at] !== 0) {
          const taken = this.take(at, height, Infinity, touch);
          if (taken > 0) this.marks[at] = Math.max(mark, this.marks[at]);
          lowered += taken;
          continue;
        }
        const depth = heights[at] - height;
        if (!(depth > touch)) continue;
        heights[at] = height;
        this.marks[at] = Math.max(mark, this.marks[at]);
        lowered += depth;
      }
      this.work += Math.max(0, stop - begin + 1);
      if (lowered > 0) {
        volume += lowered * dx * dy;
        if (row < this.changed[0]) this.changed[0] = row;
        if (row > this.changed[1]) this.changed[1] = row;
      }
    }
    this.work += 1 + Math.max(0, last - first + 1);
    this.removed += volume;
    return volume;
  }

  cutTilted({ radius, isBall }, reach, from, to, axis, isRapid) {
    const way = { from, to, axis, radius: reach, centre: isBall ? radius : 0 };
    const { dx, dy, nx, ny, low } = this;
    const corners = shadow({ ...way, radius }, low, this.high);
    this.work = 1;
    if (!corners) return 0;
    const sweep = new Sweep(way);
    const touch = isRapid ? TOUCH * this.cell : 0;
    const mark = isRapid ? CRASHED : CUT;
    const ys = corners.map((corner) => corner[1]);
    const first = Math.max(0, Math.ceil((Math.min(...ys) - radius - low[1]) / dy - 0.5));
    const last = Math.min(ny - 1, Math.floor((Math.max(...ys) + radius - low[1]) / dy - 0.5));
    let volume = 0;
    for (let row = first; row <= last; row++) {
      const cy = low[1] + (row + 0.5) * dy;
      const span = spanOf(corners, cy, radius);
      this.work += 1;
      if (!span) continue;
      const begin = Math.max(0, Math.ceil((span[0] - low[0]) / dx - 0.5));
      const stop = Math.min(nx - 1, Math.floor((span[1] - low[0]) / dx - 0.5));
      let taken = 0;
      for (let column = begin; column <= stop; column++) {
        if (!sweep.meets(low[0] + (column + 0.5) * dx, cy)) continue;
        const at = row * nx + column;
        const part = this.take(at, sweep.low, sweep.high, touch);
        if (part === 0) continue;
        this.marks[at] = Math.max(mark, this.marks[at]);
        taken += part;
      }
      this.work += TILTED_WORK * Math.max(0, stop - begin + 1);
      if (taken === 0) continue;
      volume += taken * dx * dy;
      this.changed = [Math.min(row, this.changed[0]), Math.max(row, this.changed[1])];
    }
    this.removed += volume;
    return volume;
  }

  /** Takes the material between two heights out of a column, and returns how much it was; less than `touch` stays. */
  take(at, from, to, touch) {
    const floor = this.low[2];
    const top = this.heights[at];
    if (this.isSplit[at] === 0) {
      const [bottom, end] = [Math.max(from, floor), Math.min(to, top)];
      if (!(end - bottom > touch)) return 0;
      if (end === top) {
        this.heights[at] = bottom;
        return top - bottom;
      }
    }
    const thin = THIN * this.cell;
    const old = this.pieces(at);
    const left = [];
    let [before, after, inside] = [0, 0, 0];
    const keep = (bottom, end) => {
      if (!(end - bottom > thin)) return;
      left.push(bottom, end);
      after += end - bottom;
    };
    for (let i = 0; i < old.length; i += 2) {
      const [bottom, end] = [old[i], old[i + 1]];
      before += end - bottom;
      const [a, b] = [Math.max(from, bottom), Math.min(to, end)];
      if (!(b > a)) {
        left.push(bottom, end);
        after += end - bottom;
        continue;
      }
      inside += b - a;
      keep(bottom, a);
      keep(b, end);
    }
    if (!(inside > touch)) return 0;
    const others = this.pieceCount - (this.isSplit[at] === 0 ? 0 : old.length / 2);
    const most = Math.max(1, Math.min(MAX_PIECES, SHARE_PIECES * this.nx * this.ny - others));
    while (left.length > 2 * most) after -= dropThinnest(left);
    const isWhole = left.length === 0 || (left.length === 2 && left[0] === floor);
    this.isSplit[at] = isWhole ? 0 : 1;
    this.pieceCount = others + (isWhole ? 0 : left.length / 2);
    if (isWhole) this.split.delete(at);
    else this.split.set(at, left);
    this.heights[at] = left.length === 0 ? floor : left.at(-1);
    return before - after;
  }
}

/** Takes the thinnest piece out of a list, and returns how thick it was. */
function dropThinnest(pieces) {
  let best = 0;
  for (let i = 2; i < pieces.length; i += 2) if (pieces[i + 1] - pieces[i] < pieces[best + 1] - pieces[best]) best = i;
  const [bottom, end] = pieces.splice(best, 2);
  return end - bottom;
}

/** Returns between which X the part of a way from the origin lies that is within reach of a row. */
function span(ax, ay, cy, reach) {
  if (ay === 0) return [Math.min(0, ax), Math.max(0, ax)];
  const limit = (y) => Math.min(1, Math.max(0, y / ay));
  const [a, b] = [ax * limit(cy - reach), ax * limit(cy + reach)];
  return [Math.min(a, b), Math.max(a, b)];
}

/**
 * Returns the box that a program's cuts need, wider by the tools and a margin; null for a program without cuts. `pose` returns
 * the tip and the direction of the tool at a point of the path, with the tool that is there at another point; without it tools
 * are upright.
 */
export function boxOf(...program) {
  const box = new Box(...program);
  while (!box.isDone) box.look();
  return box.found;
}

/** Returns the box of a program as `boxOf` does, but in parts: in between, `rest` may let others work. */
export async function boxInParts(rest, ...program) {
  const box = new Box(...program);
  while (!box.isDone) {
    box.look();
    await rest();
  }
  return box.found;
}

/** The box of a program's cuts, as far as it has been looked at. */
class Box {
  constructor(path, frame, tools, margin, pose = null) {
    Object.assign(this, { path, frame, tools, margin, pose });
    this.low = [Infinity, Infinity, Infinity];
    this.high = [-Infinity, -Infinity, -Infinity];
    this.isCut = false;
    this.next = 1;
    // One point for all: a long program has millions.
    this.point = [0, 0, 0];
  }

  get isDone() {
    return this.next >= this.path.count;
  }

  /** Looks at the next points. */
  look() {
    const { kinds, tools: numbers, count } = this.path;
    const end = Math.min(count, this.next + (this.pose ? POSE_LOOK : LOOK));
    for (let i = this.next; i < end; i++) {
      if (kinds[i] <= RAPID) continue;
      const tool = this.tools(numbers[i]);
      if (kinds[i - 1] <= RAPID) this.add(i - 1, i, tool);
      this.add(i, i, tool);
    }
    this.next = end;
  }

  add(at, as, { radius, isBall }) {
    const { frame, low, high, point } = this;
    const posed = this.pose ? this.pose(at, as) : null;
    frame.part(posed ? posed.tip : this.path.tip(at, as, point), point);
    const [x, y, z] = point;
    if (!Number.isFinite(x + y + z)) return;
    if (x - radius < low[0]) low[0] = x - radius;
    if (x + radius > high[0]) high[0] = x + radius;
    if (y - radius < low[1]) low[1] = y - radius;
    if (y + radius > high[1]) high[1] = y + radius;
    // A cut begins where the move before has ended, above the stock mostly: the height of its end counts.
    if (at !== as) return;
    const bottom = posed?.axis ? z - deeper(frame.vector(posed.axis)[2], radius, isBall) : z;
    if (bottom < low[2]) low[2] = bottom;
    if (z > high[2]) high[2] = z;
    this.isCut = true;
  }

  get found() {
    const { low, high, margin } = this;
    if (!this.isCut) return null;
    // The zero of a part is its upper side as a rule.
    const top = low[2] < 0 ? 0 : high[2];
    return [[low[0] - margin, low[1] - margin, low[2] - margin], [high[0] + margin, high[1] + margin, Math.max(top, low[2])]];
  }
}

/** Returns how far a tool that leans reaches below its tip: with an edge of its end, or with its ball. */
function deeper(upright, radius, isBall) {
  return isBall ? radius * (1 - upright) : radius * Math.sqrt(Math.max(0, 1 - upright * upright));
}
