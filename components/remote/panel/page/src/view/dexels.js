// Stock as a field of heights, cut by tools that move, without anything of the browser.
//
// A cell has the height of the material above it. Tools come from above, so that a height says all.

import { RAPID } from "./path.js";

/** Number of cells of a field at most. */
export const MAX_CELLS = 40_000;
/** What has cut a cell. */
export const [UNCUT, CUT, CRASHED] = [0, 1, 2];
/** Depth, in sizes of a cell, below which a rapid move only touches: points are rounded. */
const TOUCH = 1e-2;

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

  /**
   * Cuts with a tool whose tip moves straight from one point to another; `tool` has `radius` and `isBall`. Returns the
   * volume that this removes, and in `work` how many cells it has looked at.
   *
   * A rapid move is taken to be half a cell narrower: it does not cut what it only slides along.
   */
  cut({ radius, isBall }, from, to, isRapid = false) {
    this.work = 0;
    const reach = isRapid ? radius - this.cell / 2 : radius;
    const isKnown = [...from, ...to].every(Number.isFinite) && reach > 0 && Number.isFinite(radius);
    if (!isKnown) return 0;
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
    const { dx, dy, nx, ny, heights } = this;
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
}

/** Returns between which X the part of a way from the origin lies that is within reach of a row. */
function span(ax, ay, cy, reach) {
  if (ay === 0) return [Math.min(0, ax), Math.max(0, ax)];
  const limit = (y) => Math.min(1, Math.max(0, y / ay));
  const [a, b] = [ax * limit(cy - reach), ax * limit(cy + reach)];
  return [Math.min(a, b), Math.max(a, b)];
}

/** Returns the box that a program's cuts need, wider by the tools and a margin; null for a program without cuts. */
export function boxOf(path, frame, tools, margin) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  let isCut = false;
  for (let i = 1; i < path.count; i++) {
    if (path.kinds[i] <= RAPID) continue;
    const { radius } = tools(path.tools[i]);
    const begins = path.kinds[i - 1] <= RAPID;
    for (const at of begins ? [i - 1, i] : [i]) {
      const point = frame.part(path.tip(at, i));
      if (!point.every(Number.isFinite)) continue;
      for (const axis of [0, 1]) {
        low[axis] = Math.min(low[axis], point[axis] - radius);
        high[axis] = Math.max(high[axis], point[axis] + radius);
      }
      // A cut begins where the move before has ended, above the stock mostly: the height of its end counts.
      if (at === i) {
        low[2] = Math.min(low[2], point[2]);
        high[2] = Math.max(high[2], point[2]);
        isCut = true;
      }
    }
  }
  if (!isCut) return null;
  // The zero of a part is its upper side as a rule.
  const top = low[2] < 0 ? 0 : high[2];
  return [[low[0] - margin, low[1] - margin, low[2] - margin], [high[0] + margin, high[1] + margin, Math.max(top, low[2])]];
}
