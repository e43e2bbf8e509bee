// The path of a program, as the server computes it: FERPATH1 in API.md.

import { BufferAttribute, BufferGeometry, Color, LineBasicMaterial, LineSegments } from "../../vendor/three.module.min.js";

const MAGIC = "FERPATH1";
const HEADER_BYTES = 64;
const RAPID = 1;
/** Segments of a part: so few that 16 bits count their points. */
const PART = 30_000;
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

/** Lines of a path: parts that are made when they are drawn first, and a coarse picture of the whole. */
export class PathLines {
  constructor(path, { rapid, colourBy }) {
    this.path = path;
    this.materials = [
      new LineBasicMaterial({ vertexColors: true }), new LineBasicMaterial({ color: rapid, transparent: true, opacity: 0.55 }),
    ];
    this.paint = colourBy === "feed" ? byFeed(path) : byTool(path);
    this.parts = [];
    this.coarse = this.join(thinned(path));
  }

  /** Number of parts. */
  get count() {
    return Math.ceil((this.path.count - 1) / PART);
  }

  /** Returns the lines of a part. Each has buffers of its own: the browser takes them over one by one, and answers in between. */
  part(index) {
    this.parts[index] ??= this.join(slice(this.path, index * PART, Math.min(this.path.count, (index + 1) * PART + 1)));
    return this.parts[index];
  }

  /** Makes the lines that join points: those of cuts, and those of rapids. */
  join(some) {
    const positions = new BufferAttribute(some.points, 3);
    const made = [true, false].map((areCuts) => {
      const pairs = segments(some.kinds, areCuts);
      if (pairs.length === 0) return null;
      const geometry = new BufferGeometry().setAttribute("position", positions).setIndex(new BufferAttribute(pairs, 1));
      if (areCuts) geometry.setAttribute("color", new BufferAttribute(this.paint(some), 4, true));
      const object = new LineSegments(geometry, this.materials[areCuts ? 0 : 1]);
      object.frustumCulled = false;
      object.position.set(...this.path.origin);
      return object;
    });
    return made.filter(Boolean);
  }

  dispose() {
    for (const object of [...this.parts.flat(), ...this.coarse]) object?.geometry.dispose();
    for (const material of this.materials) material.dispose();
  }
}

/** Returns the points of a range. */
function slice({ points, kinds, tools, feeds }, first, end) {
  return {
    points: points.subarray(3 * first, 3 * end), kinds: kinds.subarray(first, end), tools: tools.subarray(first, end), feeds: feeds.subarray(first, end),
  };
}

/** Returns the pairs of neighbours that cuts, or rapids, join. */
function segments(kinds, areCuts) {
  const pairs = new Uint16Array(2 * kinds.length);
  let n = 0;
  for (let i = 1; i < kinds.length; i++) {
    if (kinds[i] !== 0 && kinds[i] > RAPID === areCuts) {
      pairs[n++] = i - 1;
      pairs[n++] = i;
    }
  }
  return pairs.subarray(0, n);
}

/** Returns every n-th point: few lines that follow the same way. */
function thinned(path) {
  const stride = Math.ceil(path.count / COARSE);
  const count = Math.ceil(path.count / stride);
  const thin = { points: new Float32Array(3 * count), kinds: new Uint8Array(count), tools: new Uint16Array(count), feeds: new Float32Array(count) };
  for (let i = 0; i < count; i++) {
    const at = i * stride;
    for (let k = 0; k < 3; k++) thin.points[3 * i + k] = path.points[3 * at + k];
    for (const name of ["kinds", "tools", "feeds"]) thin[name][i] = path[name][at];
  }
  return thin;
}

/** Returns the function that paints points by their tool. */
function byTool() {
  const table = TOOL_COLOURS.map(rgba);
  return ({ tools }) => paint(tools.length, (i) => table[tools[i] % table.length]);
}

/** Returns the function that paints points by their feed: blue is slow, red is the fastest of the program. */
function byFeed({ feeds: all }) {
  let most = 1e-9;
  for (const feed of all) most = Math.max(most, feed);
  const table = Array.from({ length: 256 }, (_, i) => rgba(new Color().setHSL(0.66 - (0.66 * i) / 255, 0.9, 0.6)));
  return ({ feeds }) => paint(feeds.length, (i) => table[Math.round((255 * Math.max(0, feeds[i])) / most)]);
}

/** Returns the colours of points: four bytes each, because graphics processors read no three. */
function paint(count, colour) {
  const words = new Uint32Array(count);
  for (let i = 0; i < count; i++) words[i] = colour(i);
  return new Uint8Array(words.buffer);
}

/** Returns a colour as a word whose bytes are red, green, blue and 255 in memory. */
function rgba(colour) {
  const { r, g, b } = new Color(colour);
  return new Uint32Array(new Uint8Array([...[r, g, b].map((v) => Math.round(255 * v)), 255]).buffer)[0];
}
