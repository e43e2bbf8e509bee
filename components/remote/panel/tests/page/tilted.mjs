// Stock that tilted tools cut, against closed forms. Run by `tests/page.rs`.

import assert from "node:assert/strict";

const { ball, flat, near } = await import("./tools.mjs");
const { CRASHED, CUT, Dexels, MAX_CELLS } = await import("../../page/src/view/dexels.js");
const { Sweep, beside, cross, dot, length } = await import("../../page/src/view/sweep.js");

const FINE = 1_000_000;
const block = (most) => new Dexels([0, 0, -20], [100, 60, 0], most);
const radians = (angle) => (angle * Math.PI) / 180;
/** Returns the direction of a tool that leans by an angle from the upright, in a direction about Z. */
const lean = (angle, about = 0) => [
  Math.sin(radians(angle)) * Math.cos(radians(about)), Math.sin(radians(angle)) * Math.sin(radians(about)), Math.cos(radians(angle)),
];

/** Returns the volume of all pieces. */
function left(stock) {
  let sum = 0;
  for (let at = 0; at < stock.heights.length; at++) {
    const pieces = stock.pieces(at);
    assert.ok(pieces.every((v, i) => i === 0 || v > pieces[i - 1]), `${pieces}`);
    assert.equal(stock.heights[at], pieces.length > 0 ? pieces.at(-1) : stock.low[2]);
    for (let i = 0; i < pieces.length; i += 2) sum += pieces[i + 1] - pieces[i];
  }
  return sum * stock.dx * stock.dy;
}

/** Checks what is left, and that the same way removes nothing twice. */
function whole(stock, ...cuts) {
  const all = [0, 1, 2].reduce((v, axis) => v * (stock.high[axis] - stock.low[axis]), 1);
  near(left(stock), all - stock.removed, 1e-6 * all);
  for (const cut of cuts) assert.ok(stock.cut(...cut) < 1e-6 * stock.removed + 1e-9);
}

let seed = 7;
function random(low, high) {
  seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
  return low + ((high - low) * seed) / 2 ** 32;
}
const point = (size) => [0, 1, 2].map(() => random(-size, size));
function direction() {
  const v = point(1);
  const size = length(v);
  return size > 0.1 && size < 1 ? v.map((x) => x / size) : direction();
}

// Where lines enter and leave a sweep, against the tool at many places of its way.
{
  /** Returns between which heights a line meets a tool that stands. */
  const stands = (tip, axis, radius, centre, [cx, cy]) => {
    const at = tip.map((v, i) => v + centre * axis[i]);
    const u = beside(axis);
    const [v, e] = [cross(axis, u), [cx - at[0], cy - at[1], -at[2]]];
    const parts = [];
    const [a, b, c] = [u[2] ** 2 + v[2] ** 2, dot(e, u) * u[2] + dot(e, v) * v[2], dot(e, u) ** 2 + dot(e, v) ** 2 - radius ** 2];
    if (b * b - a * c > 0) {
      let [low, high] = [-1, 1].map((sign) => (-b + sign * Math.sqrt(b * b - a * c)) / a);
      const end = -dot(e, axis) / axis[2];
      if (axis[2] > 0) low = Math.max(low, end);
      else high = Math.min(high, end);
      if (low < high) parts.push(low, high);
    }
    const root = e[2] ** 2 - (dot(e, e) - radius ** 2);
    if (centre > 0 && root > 0) parts.push(-e[2] - Math.sqrt(root), -e[2] + Math.sqrt(root));
    return parts.length > 0 ? [Math.min(...parts), Math.max(...parts)] : null;
  };
  let met = 0;
  for (let n = 0; n < 800; n++) {
    const [from, axis, radius] = [point(5), direction(), random(0.5, 4)];
    // Also ways along the tool, across it, and none.
    const way = [point(8), axis.map((v) => v * random(-8, 8)), beside(axis).map((v) => v * random(-8, 8)), [0, 0, 0]][n % 4];
    const to = from.map((v, i) => v + way[i]);
    const centre = n % 8 < 4 ? radius : 0;
    const sweep = new Sweep({ from, to, axis, radius, centre });
    const line = [random(-8, 8), random(-8, 8)];
    const found = sweep.meets(...line) ? [sweep.low, sweep.high] : null;
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i <= 4000; i++) {
      const heights = stands(from.map((v, k) => v + (i / 4000) * way[k]), axis, radius, centre, line);
      if (heights) [low, high] = [Math.min(low, heights[0]), Math.max(high, heights[1])];
    }
    if (!(low < high)) {
      assert.ok(!found || found[1] - found[0] < 0.5, `${n}: ${found}`);
      continue;
    }
    met += 1;
    // Steps of the way miss the ends by a little, where the line only touches by more.
    const tolerance = high - low < 1 ? 0.2 : 0.03;
    assert.ok(found, `${n}`);
    near(found[0], low, tolerance);
    near(found[1], high, tolerance);
    assert.ok(found[0] <= low + 1e-9 && found[1] >= high - 1e-9, `${n}: ${found} within ${[low, high]}`);
  }
  assert.ok(met > 100, `${met}`);
}

// A tool that is tilted by nothing cuts the same by either way, cell by cell.
for (let n = 0; n < 60; n++) {
  const [one, other] = [block(3000), block(3000)];
  const tool = n % 2 ? flat(random(1, 12)) : ball(random(1, 12));
  for (let k = 0; k < 3; k++) {
    const [from, to] = [0, 1].map(() => [random(-10, 110), random(-10, 70), random(-25, 5)]);
    if (n % 5 === 0) [to[0], to[1]] = from;
    one.cut(tool, from, to);
    other.cutTilted(tool, tool.radius, from, to, [0, 0, 1], false);
  }
  one.heights.forEach((height, at) => near(other.heights[at], height, 1e-6));
  assert.equal(other.split.size, 0);
}

const [D, H] = [8, 10];
const R = D / 2;

// Plunged along itself, a cylinder that leans removes its length up to the surface; it may lean anywhere.
for (const [angle, about] of [[30, 0], [30, 77], [30, 200], [60, -30], [5, 45]]) {
  const axis = lean(angle, about);
  // The deepest point of its end is above the floor.
  const tip = [50, 30, -H];
  const above = tip.map((v, i) => v + 40 * axis[i]);
  const closed = (Math.PI * R * R * H) / axis[2];
  for (const [most, share] of [[MAX_CELLS, 0], [FINE, 0.004]]) {
    const stock = block(most);
    const volume = stock.cut(flat(D), above, tip, false, axis);
    // Seen from above, its outline counts whole cells: half a cell is the most, over the height of its sides.
    const outline = Math.PI * D + (2 * H) / axis[2];
    near(volume, closed, share ? share * closed : 0.5 * stock.cell * outline * D);
    whole(stock, [flat(D), tip, above, false, axis], [flat(D), tip, tip, false, axis]);
  }
}

// Slots of a tool that leans to the side, and of one that leans along its way, whichever way it goes.
for (const about of [0, 30, 90, 145]) {
  for (const angle of [15, 30, 50]) {
    const [along, across] = [lean(90, about), lean(90, about + 90)];
    const long = 20;
    const ends = [-1, 1].map((sign) => [50, 30, -H].map((v, i) => v + (sign * long * along[i]) / 2));
    const side = lean(angle, about + 90);
    assert.ok(Math.abs(dot(side, along)) < 1e-12 && Math.abs(dot(along, across)) < 1e-12);
    const end = (Math.PI * R * R * H) / Math.cos(radians(angle));
    const slots = [
      [side, end + (long * D * H) / Math.cos(radians(angle))],
      // Its lowest edge is deeper than the tip.
      [lean(angle, about), end + long * (D * H + (Math.sin(radians(angle)) * Math.PI * R * R) / 2)],
      [lean(angle, about + 180), end + long * (D * H + (Math.sin(radians(angle)) * Math.PI * R * R) / 2)],
    ];
    for (const [axis, closed] of slots) {
      for (const [from, to] of [ends, [...ends].reverse()]) {
        const stock = block();
        const volume = stock.cut(flat(D), from, to, false, axis);
        near(volume, closed, 0.5 * stock.cell * (2 * long + Math.PI * D + (2 * H) / axis[2]) * H);
        near(block(FINE).cut(flat(D), from, to, false, axis), closed, 0.01 * closed);
        whole(stock, [flat(D), to, from, false, axis]);
      }
    }
  }
}

// As long as only the ball touches, its slot is the same however it leans; so it is on a slope.
{
  const depth = 1;
  const segment = R * R * Math.acos((R - depth) / R) - (R - depth) * Math.sqrt(2 * R * depth - depth * depth);
  const closed = 40 * segment + (Math.PI * depth * depth * (3 * R - depth)) / 3;
  for (const [angle, about] of [[0, 0], [10, 0], [25, 90], [40, 0], [40, 60], [40, 180], [40, -100]]) {
    const axis = lean(angle, about);
    // The ball's lowest point stays where it is.
    const at = (x) => [x, 30, -depth + R].map((v, i) => v - R * axis[i]);
    const stock = block();
    const volume = stock.cut(ball(D), at(30), at(70), false, axis);
    near(volume, closed, 0.5 * stock.cell * 2 * 40 * depth);
    near(block(FINE).cut(ball(D), at(30), at(70), false, axis), closed, 0.01 * closed);
    whole(stock, [ball(D), at(70), at(30), false, axis]);
    assert.equal(stock.split.size, 0);
    const slope = new Dexels([0, 0, -20], [100, 60, 20]);
    slope.cut(ball(D), [30, 30, 20 + R].map((v, i) => v - R * axis[i]), [70, 30, -20 + R].map((v, i) => v - R * axis[i]), false, axis);
    const column = Math.floor(60 / slope.dx);
    const x = (column + 0.5) * slope.dx;
    const row = Math.floor(30 / slope.dy);
    const offset = (row + 0.5) * slope.dy - 30;
    // A cylinder of radius R whose axis falls 1 : 1, seen from above at a place beside its middle.
    near(slope.pieces(row * slope.nx + column)[1], 20 + R - (x - 30) - Math.SQRT2 * Math.sqrt(R * R - offset * offset), 1e-9);
  }
}

// A level tool through the side of the block bores a tunnel, and mills it wider: the roof stays.
{
  const stock = block();
  const level = [1, 0, 0];
  const [deep, wide] = [60, 10];
  stock.cut(flat(D), [120, 30, -H], [100 - deep, 30, -H], false, level);
  near(stock.removed, Math.PI * R * R * deep, 0.5 * stock.cell * 2 * (deep + D) * D);
  assert.ok(stock.heights.every((height) => height === 0));
  stock.cut(flat(D), [100 - deep, 30, -H], [100 - deep, 30 + wide, -H], false, level);
  const tunnel = (Math.PI * R * R + wide * D) * deep;
  near(stock.removed, tunnel, 0.5 * stock.cell * 2 * (deep + wide + D) * D);
  near(stock.removed, tunnel, 0.03 * tunnel);
  const at = (x, y) => Math.floor(y / stock.dy) * stock.nx + Math.floor(x / stock.dx);
  assert.deepEqual(stock.pieces(at(70, 35)).map((v) => Math.round(1e6 * v) / 1e6), [-20, -H - R, -H + R, 0]);
  whole(stock, [flat(D), [100 - deep, 30 + wide, -H], [100 - deep, 30, -H], false, level]);
  // From above through the roof: what the tunnel has is there no more.
  const { removed } = stock;
  const roof = stock.cut(flat(6), [70, 34, 5], [70, 34, -16]);
  near(roof, Math.PI * 9 * (16 - D), 0.5 * stock.cell * Math.PI * 6 * 16);
  near(stock.removed, removed + roof, 1e-9);
  assert.deepEqual(stock.pieces(at(70, 34)), [-20, -16]);
  assert.equal(stock.isSplit[at(70, 34)], 0);
  whole(stock);
  // From below, what was in between falls away: nothing holds a height that is no more.
  const through = stock.cut(flat(6), [70, 34, -25], [70, 34, -10], false, [0, 0, -1]);
  near(through, Math.PI * 9 * 4, 0.5 * stock.cell * Math.PI * 6 * 4);
  assert.deepEqual(stock.pieces(at(70, 34)), []);
  whole(stock);
}

// A rapid move slides along what was cut, and is reported where it cuts.
{
  const stock = block();
  const axis = lean(30, 40);
  const [from, to] = [[30, 30, -5], [60, 35, -5]];
  stock.cut(flat(D), from, to, false, axis);
  assert.ok(stock.marks.includes(CUT) && !stock.marks.includes(CRASHED));
  assert.equal(stock.cut(flat(D), to, from, true, axis), 0);
  assert.equal(stock.cut(flat(D), from, from.map((v, i) => v + 60 * axis[i]), true, axis), 0);
  assert.ok(stock.cut(flat(D), to, [60, 35, -8], true, axis) > 0);
  assert.ok(stock.marks.includes(CRASHED));
}

// Nothing is cut by what has no direction or is outside; work and pieces are bounded.
for (const [from, to, axis] of [
  [[10, 10, -1], [20, 10, -1], [NaN, 0, 1]], [[10, 10, -1], [20, Infinity, -1], lean(30)], [[10, 10, 9], [20, 10, 9], lean(30)],
  [[-50, 10, -1], [-60, 10, -1], [-1, 0, 0]], [[10, 10, -30], [20, 10, -40], [0, 0.6, -0.8]], [[50, 30, 9], [50, 30, 9], [1, 0, 0]],
]) {
  const stock = block();
  assert.equal(stock.cut(flat(D), from, to, false, axis), 0);
  assert.ok(stock.removed === 0 && stock.marks.every((mark) => mark === 0));
}
{
  const stock = block();
  stock.cut(flat(1e6), [-1e6, -1e6, -1], [1e6, 1e6, -1], false, lean(30));
  assert.ok(stock.work <= 5 * MAX_CELLS, `${stock.work}`);
  const sieve = new Dexels([0, 0, 0], [2, 2, 400], 4);
  for (let z = 1; z < 399; z += 2) sieve.cut(flat(0.9), [-5, 0.5, z], [-5, 0.5, z], false, [-1, 0, 0]);
  for (let z = 1; z < 399; z += 2) sieve.cut(flat(0.9), [0, 0.5, z], [0, 0.5, z], false, [1, 0, 0]);
  assert.ok(sieve.split.size > 0 && [...sieve.split.values()].every((pieces) => pieces.length <= 128));
  whole(sieve);
}
