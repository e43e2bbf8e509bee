// The path of a program, as the server computes it: FERPATH1 in API.md.

import { BufferAttribute, BufferGeometry, Color, LineBasicMaterial, LineSegments } from "../../vendor/three.module.min.js";

const MAGIC = "FERPATH1";
const HEADER_BYTES = 64;
const RAPID = 1;
/** Number of segments of the coarse picture, which is drawn while the camera moves. */
const COARSE = 30_000;
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
  }

  /** Returns the share of the path's time that lies before a line of the program; `rapid` is the feed of rapids. */
  share(line, rapid) {
    this.times ??= times(this, rapid);
    const total = this.times.at(-1) ?? 0;
    if (total === 0) return 0;
    let at = 0;
    while (at < this.count - 1 && this.lines[at] < line) at++;
    return this.times[at] / total;
  }
}

/** Returns the time in minutes at which each point is reached, without accelerations. */
function times({ points, count, feeds }, rapid) {
  const all = new Float64Array(count);
  for (let i = 1; i < count; i++) {
    const p = 3 * i;
    const length = Math.hypot(points[p] - points[p - 3], points[p + 1] - points[p - 2], points[p + 2] - points[p - 1]);
    all[i] = all[i - 1] + length / (feeds[i] > 0 ? feeds[i] : rapid);
  }
  return all;
}

/** Lines of a path: all segments in parts, and a coarse picture. */
export class PathLines {
  constructor(path, { rapid, colourBy }) {
    const { count, kinds } = path;
    const positions = new BufferAttribute(path.points, 3);
    let cuts = 0;
    for (let i = 1; i < count; i++) if (kinds[i] > RAPID) cuts++;
    const all = new Uint32Array(2 * Math.max(0, cuts));
    const moves = new Uint32Array(2 * Math.max(0, count - cuts));
    let [a, m] = [0, 0];
    for (let i = 1; i < count; i++) {
      if (kinds[i] > RAPID) {
        all[a++] = i - 1;
        all[a++] = i;
      } else if (kinds[i] === RAPID) {
        moves[m++] = i - 1;
        moves[m++] = i;
      }
    }
    const colours = new BufferAttribute(colourBy === "feed" ? byFeed(path) : byTool(path), 3, true);
    const coloured = new LineBasicMaterial({ vertexColors: true });
    const rapids = new LineBasicMaterial({ color: rapid, transparent: true, opacity: 0.55 });
    this.fine = [lines(positions, all.subarray(0, a), coloured, colours), lines(positions, moves.subarray(0, m), rapids, null)];
    this.coarse = [
      lines(positions, thinned(all.subarray(0, a)), coloured, colours),
      lines(positions, thinned(moves.subarray(0, m)), rapids, null),
    ];
    this.sizes = [a, m];
    for (const object of [...this.fine, ...this.coarse]) object.position.set(...path.origin);
  }

  /** Number of indices of all segments. */
  get total() {
    return this.sizes[0] + this.sizes[1];
  }

  /** Lets the fine lines draw `count` indices from `first` of all. */
  range(first, count) {
    let at = first;
    let left = count;
    this.fine.forEach((object, i) => {
      const size = this.sizes[i];
      const begin = Math.min(size, Math.max(0, at));
      const take = Math.min(size - begin, left);
      object.geometry.setDrawRange(begin, Math.max(0, take));
      object.visible = take > 0;
      left -= Math.max(0, take);
      at -= size;
    });
  }

  dispose() {
    for (const object of [...this.fine, ...this.coarse]) object.geometry.dispose();
  }
}

/** Joins the starts of every n-th segment, so that few lines follow the same way. */
function thinned(index) {
  const segments = index.length / 2;
  const stride = Math.ceil(segments / COARSE);
  if (stride <= 1) return index;
  const out = new Uint32Array(2 * Math.ceil(segments / stride));
  let n = 0;
  for (let s = 0; s < segments; s += stride) {
    const last = Math.min(segments - 1, s + stride - 1);
    // Pieces with a gap between them are not joined.
    const isWhole = index[2 * last + 1] - index[2 * s] === last - s + 1;
    out[n++] = index[2 * s];
    out[n++] = isWhole ? index[2 * last + 1] : index[2 * s + 1];
  }
  return out.subarray(0, n);
}

function lines(positions, index, material, colours) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", positions);
  if (colours) geometry.setAttribute("color", colours);
  geometry.setIndex(new BufferAttribute(index, 1));
  const object = new LineSegments(geometry, material);
  object.frustumCulled = false;
  return object;
}

function byTool({ count, tools }) {
  const table = TOOL_COLOURS.map(rgb);
  const out = new Uint8Array(3 * count);
  for (let i = 0; i < count; i++) out.set(table[tools[i] % table.length], 3 * i);
  return out;
}

function byFeed({ count, feeds }) {
  let most = 0;
  for (let i = 0; i < count; i++) most = Math.max(most, feeds[i]);
  const table = Array.from({ length: 256 }, (_, i) => rgb(new Color().setHSL(0.66 - (0.66 * i) / 255, 0.9, 0.6)));
  const out = new Uint8Array(3 * count);
  for (let i = 0; i < count; i++) out.set(table[most > 0 ? Math.round((255 * Math.max(0, feeds[i])) / most) : 0], 3 * i);
  return out;
}

function rgb(colour) {
  const { r, g, b } = new Color(colour);
  return [r, g, b].map((v) => Math.round(255 * v));
}
