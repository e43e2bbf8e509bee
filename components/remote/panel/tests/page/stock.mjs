// Stock that tools cut, and programs that are played over it, against closed forms. Run by `tests/page.rs`.

import assert from "node:assert/strict";

const { ball, flat, near } = await import("./tools.mjs");
const { Frame } = await import("../../page/src/frame.js");
const { CRASHED, CUT, Dexels, MAX_CELLS, boxOf } = await import("../../page/src/view/dexels.js");
const { Path } = await import("../../page/src/view/path.js");
const { bytes } = await import("./bytes.mjs");
const { Carver, Player } = await import("../../page/src/view/player.js");

const block = (most) => new Dexels([0, 0, -10], [100, 50, 0], most);

/** Sum of what is missing, cell by cell. */
function missing(stock) {
  return stock.heights.reduce((sum, height) => sum + (stock.high[2] - height), 0) * stock.dx * stock.dy;
}

// A straight slot has its length times its width and depth, and the two halves of the tool; it may be in any direction.
// Along its edge a cell counts whole or not: half a cell is the most.
const [D, H] = [8, 3];
for (const [from, to] of [[[20, 25], [80, 25]], [[50, 10], [50, 40]], [[20, 10], [80, 40]], [[80, 10], [20, 40]]]) {
  const stock = block();
  const long = Math.hypot(to[0] - from[0], to[1] - from[1]);
  const volume = stock.cut(flat(D), [...from, -H], [...to, -H]);
  const around = 2 * long + Math.PI * D;
  near(volume, H * (long * D + (Math.PI * D * D) / 4), 0.5 * around * stock.cell * H);
  const fine = block(1_000_000).cut(flat(D), [...from, -H], [...to, -H]);
  near(fine, H * (long * D + (Math.PI * D * D) / 4), 0.01 * volume);
  near(missing(stock), stock.removed, 1e-6);
  assert.equal(stock.removed, volume);
  // The same way again removes nothing, nor does one above.
  assert.equal(stock.cut(flat(D), [...to, -H], [...from, -H]) < 1e-9, true);
  assert.equal(stock.cut(flat(D), [...from, 0], [...to, 5]), 0);
}

// A ramp: half of the depth over its length, and the deep half of the tool. The end behind the tool is level.
{
  const volume = block(1_000_000).cut(flat(D), [20, 25, 0], [80, 25, -6]);
  let closed = 0;
  // Across, at distance s, the tool reaches half = √(r² - s²) ahead: the depth is that of the place so far ahead.
  for (let s = -D / 2 + 0.0005; s < D / 2; s += 0.001) closed += 0.001 * (0.5 * 60 * 6 + 2 * Math.sqrt((D * D) / 4 - s * s) * 6);
  near(volume, closed, 0.01 * closed);
}

// A pocket in rows: the rectangle with round corners.
{
  const stock = block(1_000_000);
  for (let y = 15; y <= 35; y += 5) stock.cut(flat(D), [20, y, -H], [80, y, -H]);
  const [a, b, r] = [60, 20, D / 2];
  // Between two rows the ends keep cusps: chords of the tool 5 apart.
  const cusp = 5 * r - (2.5 * Math.sqrt(r * r - 6.25) + r * r * Math.asin(2.5 / r));
  const area = a * b + 2 * a * r + 2 * b * r + Math.PI * r * r - 2 * 4 * cusp;
  near(stock.removed, H * area, 0.005 * H * area);
}

// A ball leaves scallops between its rows: r - √(r² - (s/2)²) high. Its slot is a half cylinder.
{
  const stock = new Dexels([0, 0, -10], [20, 20, 0], 40_000);
  const [r, step] = [4, 3];
  for (let y = 4; y <= 16; y += step) stock.cut(ball(2 * r), [-10, y, -r], [30, y, -r]);
  const at = (x, y) => stock.heights[Math.floor(y / stock.dy) * stock.nx + Math.floor(x / stock.dx)];
  near(at(10, 4) - -r, 0, 1e-3);
  near(at(10, 5.5) - -r, r - Math.sqrt(r * r - (step / 2) ** 2), 0.5 * stock.cell);
  const one = new Dexels([0, 0, -10], [20, 20, 0]);
  near(one.cut(ball(2 * r), [-10, 10, -r], [30, 10, -r]), 20 * ((Math.PI * r * r) / 2), 0.05 * 20 * r);
  // Straight down it is a cylinder with a half ball; on a slope it has the same bottom across its way.
  const down = new Dexels([0, 0, -10], [20, 20, 0]);
  near(down.cut(ball(2 * r), [10, 10, 5], [10, 10, -6]), Math.PI * r * r * 2 + (2 / 3) * Math.PI * r ** 3, 1);
  const slope = new Dexels([0, 0, -20], [20, 20, 20]);
  slope.cut(ball(2 * r), [-20, 10, 25], [40, 10, -35]);
  // The lowest line of a cylinder of radius r whose axis falls 1 : 1 lies r (√2 - 1) below the line of tips.
  const middle = slope.heights[Math.floor(10 / slope.dy) * slope.nx + Math.floor(10 / slope.dx)];
  const x = (Math.floor(10 / slope.dx) + 0.5) * slope.dx;
  near(middle, 5 - x - r * (Math.SQRT2 - 1), 1e-3);
}

// Nothing is cut by what is no number or no tool, and below its floor a block has nothing.
for (const [tool, from, to] of [
  [flat(D), [NaN, 0, -1], [10, 10, -1]], [flat(D), [0, 0, -1], [Infinity, 0, -1]], [flat(NaN), [0, 0, -1], [10, 0, -1]],
  [flat(0), [0, 0, -1], [10, 0, -1]], [flat(-4), [0, 0, -1], [10, 0, -1]], [flat(Infinity), [0, 0, -1], [10, 0, -1]],
  [flat(D), [-50, -50, -1], [-20, -60, -1]],
]) {
  const stock = block();
  assert.equal(stock.cut(tool, from, to), 0);
  assert.ok(stock.removed === 0 && stock.marks.every((mark) => mark === 0));
}
{
  const stock = block();
  stock.cut(flat(1000), [50, 25, -1e9], [50, 25, -1e9]);
  near(stock.removed, 100 * 50 * 10, 1e-6);
  assert.ok(stock.heights.every((height) => height === -10));
}

// The number of cells is bounded, whatever the box; what is no box is refused.
for (const size of [[1, 1], [1e9, 1], [1, 1e9], [1e-9, 1e-9], [123.4, 5678], [1e30, 1e-30], [3e5, 1]]) {
  for (const most of [1, 7, 100, MAX_CELLS]) {
    const { nx, ny, heights } = new Dexels([0, 0, 0], [...size, 1], most);
    assert.ok(1 <= nx && 1 <= ny && nx * ny <= most && heights.length === nx * ny, `${size}: ${nx} × ${ny} of ${most}`);
  }
}
for (const [low, high] of [[[0, 0, 0], [0, 1, 1]], [[0, 0, 0], [1, NaN, 1]], [[0, 0, 0], [1, 1, -1]], [[0, 0, 0], [1, Infinity, 1]], [[], []]]) {
  assert.throws(() => new Dexels(low, high), RangeError);
}

const path = (points, more) => new Path(bytes(points, more));
const way = (...all) => all.map(([kind, ...at]) => ({ kind, at }));

function player(points, { stock = block(), tool = flat(D), more, frame = new Frame() } = {}) {
  const made = path(points, more);
  return new Player({ path: made, times: made.timeline(6000), tools: () => tool, stock, frame });
}
const all = (made) => {
  while (!made.isDone) made.play(Infinity, 1e5);
  return made;
};

// A program: down, a slot, and a rapid move back through what was not cut. What a rapid slides along is no harm.
const slot = [[0, 0, 0, 5], [1, 20, 25, 5], [2, 20, 25, -H], [2, 80, 25, -H], [1, 80, 25, 5]];
{
  const good = all(player(way(...slot, [1, 0, 0, 5])));
  assert.deepEqual(good.rapids, []);
  near(good.stock.removed, H * (60 * D + (Math.PI * D * D) / 4), 0.03 * good.stock.removed);
  const back = all(player(way(...slot.slice(0, 4), [1, 20, 25, -H], [1, 20, 25, 5])));
  assert.deepEqual(back.rapids, []);
  const bad = all(player(way(...slot.slice(0, 4), [1, 80, 40, -H], [1, 80, 40, 5], [1, 10, 40, 5], [1, 10, 10, -1])));
  assert.deepEqual(bad.rapids, [4, 7]);
  assert.ok(bad.stock.marks.includes(CRASHED) && bad.stock.marks.includes(CUT));
}

// In parts, in time and at once it is the same; a part ends where time or work do.
{
  const points = way(...slot.slice(0, 4), [1, 80, 40, -H], [1, 80, 40, 5]);
  const whole = all(player(points));
  const parts = player(points);
  for (let n = 0; !parts.isDone; n++) {
    parts.play(0.003, 1e5);
    assert.ok(n < 1e5 && parts.share <= 1);
  }
  // The slot falls into pieces, each of which has the ends of the tool: in all the same cells.
  near(parts.stock.removed, whole.stock.removed, 0.002 * whole.stock.removed);
  assert.deepEqual(parts.rapids, whole.rapids);
  const timed = player(points);
  // A minute at 600 is 600 far; the rapid move before it goes (20, 25) at 6000, then 8 down at 600.
  const before = Math.hypot(20, 25) / 6000 + 8 / 600;
  timed.play(before + 0.05, 1e9);
  timed.tip.forEach((v, i) => near(v, [50, 25, -H][i], 1e-6));
  assert.ok(!timed.isDone && 0 < timed.share && timed.share < 1);
  const bounded = player(points);
  bounded.play(Infinity, 1);
  assert.equal(bounded.next, 2);
}

// Work is bounded by the number of cells, however large the tool.
{
  const stock = block();
  stock.cut(flat(1e6), [-1e6, -1e6, -1], [1e6, 1e6, -1]);
  assert.ok(stock.work <= 2 * MAX_CELLS, `${stock.work}`);
}

// Without points there is nothing to play; NaN moves nothing; without a stock the tool alone moves.
assert.throws(() => player([]), RangeError);
assert.throws(() => player(way([0, 0, 0, 0])), RangeError);
assert.equal(all(player(way([0, 0, 0, 0], [2, NaN, 0, -5], [2, 10, NaN, -5]))).stock.removed, 0);
assert.deepEqual(all(player(way(...slot), { stock: null })).tip, [80, 25, 5]);

// The offset of the tool is the tool's length: also before G43 and after G49, for as long as it is in the spindle.
{
  const up = slot.map(([kind, x, y, z]) => ({ kind, at: [x, y, z + 30] }));
  const long = player(up, { more: { changes: [[2, 0, 0, 30], [4, 0, 0, 0]] } });
  near(all(long).stock.removed, H * (60 * D + (Math.PI * D * D) / 4), 0.03 * long.stock.removed);
  assert.deepEqual(long.rapids, []);
  assert.deepEqual([0, 4].map((i) => long.path.tip(i)), [[0, 0, 5], [80, 25, 5]]);
  // Another tool without an offset has none; to change it is no move.
  const two = [...up, { kind: 1, at: [80, 25, 5], tool: 2 }];
  const other = player(two, { more: { changes: [[2, 0, 0, 30], [5, 0, 0, 0]] } });
  assert.deepEqual([4, 5].map((i) => other.path.tip(i)), [[80, 25, 5], [80, 25, 5]]);
  assert.deepEqual(all(other).rapids, []);
  assert.equal(path(up).offset(3), null);
}
assert.equal(path(way(...slot), { flags: 1 | (1 << 3) | (1 << 7) }).others, "BW");

// The box of a program: its cuts with the tools and a margin, up to the zero; in the frame of the part, however it is turned.
{
  const turned = new Frame([100, 200, 10], Math.PI / 2);
  const moved = slot.map(([kind, x, y, z]) => ({ kind, at: [100 - y, 200 + x, 10 + z] }));
  const box = boxOf(path(moved), turned, () => flat(D), 2);
  box.flat().forEach((v, i) => near(v, [14, 19, -5, 86, 31, 0][i], 1e-4));
  const stock = all(player(moved, { stock: new Dexels(...box), frame: turned })).stock;
  near(stock.removed, H * (60 * D + (Math.PI * D * D) / 4), 0.02 * stock.removed);
  assert.equal(boxOf(path(way([0, 0, 0, 0], [1, 5, 5, 5])), turned, () => flat(D), 2), null);
  // Where the zero is below, the highest cut is the upper side.
  assert.equal(boxOf(path(way([0, 0, 0, 9], [2, 5, 5, 3], [2, 9, 5, 4])), new Frame(), () => flat(D), 2)[1][2], 4);
}

// The machine carves from report to report, with its tool's offset; what is not reported cuts nothing.
{
  const stock = block();
  const carver = new Carver(stock, new Frame([0, 0, 100]));
  const at = (x, z, more) => carver.report({ pose_feedback: [x, 25, 130 + z], tool_offset: [0, 0, 30], motion_type: 2, segment: 1, ...more }, flat(D));
  at(20, -H);
  assert.equal(stock.removed, 0);
  at(50, -H);
  at(80, -H);
  near(stock.removed, H * (60 * D + (Math.PI * D * D) / 4), 0.03 * stock.removed);
  const { removed } = stock;
  carver.lose();
  at(80, -9);
  assert.equal(stock.removed, removed);
  carver.report({}, flat(D));
  at(20, -9);
  assert.equal(stock.removed, removed);
  // A rapid move that cuts counts once, however often it is reported.
  for (const x of [30, 40, 50]) at(x, -9, { motion_type: 1, segment: 2 });
  at(60, -9, { motion_type: 1, segment: 3 });
  at(60, 5, { motion_type: 1, segment: 4 });
  assert.equal(carver.rapids, 2);
}
