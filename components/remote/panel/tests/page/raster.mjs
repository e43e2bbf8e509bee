// Lines that the page draws itself: places, depths, parts and what lies outside. Run by `tests/page.rs`.

import assert from "node:assert/strict";

const { Lines, Raster, word } = await import("../../page/src/view/raster.js");

const [WIDTH, HEIGHT] = [40, 30];
const [RED, GREEN] = [0xff0000, 0x00ff00];
const CUTS = [false, false, true, true, true];
const RAPIDS = [false, true, false, false, false];

/** Returns a raster whose pixel (x, y) is the point (x, y), seen from above. */
function raster() {
  const made = new Raster(WIDTH, HEIGHT);
  made.look([2 / WIDTH, 0, 0, 0, 0, -2 / HEIGHT, 0, 0, 0, 0, -0.01, 0, -1, 1, 0, 1]);
  return made;
}

function lines(...all) {
  const made = new Lines();
  for (const [from, to, colour] of all) made.add(from, to, colour);
  return made;
}

function drawn(some, kinds = CUTS) {
  const made = raster();
  made.draw(some, kinds, 0, some.kinds.length);
  return made;
}

/** Returns the pixels that have a colour, as `x,y`, with the colour and its alpha. */
function seen({ pixels, width }) {
  const all = [...pixels.entries()].filter(([, pixel]) => pixel !== 0);
  return new Map(all.map(([at, pixel]) => [`${at % width},${Math.floor(at / width)}`, [pixel & 0xffffff, pixel >>> 24]]));
}

const red = word(RED) & 0xffffff;
assert.equal(word(0x123456), 0xff563412);
assert.equal(word(0x123456, 0x80), 0x80563412);

// A line through the middles of pixels has these alone, in either direction, flat and steep.
for (const [from, to, at] of [[[2.5, 5.5, 0], [9.5, 5.5, 0], (i) => `${i},5`], [[5.5, 2.5, 0], [5.5, 9.5, 0], (i) => `5,${i}`]]) {
  for (const line of [[from, to, RED], [to, from, RED]]) {
    const found = seen(drawn(lines(line)));
    assert.deepEqual([...found.keys()].sort(), [2, 3, 4, 5, 6, 7, 8].map(at).sort());
    for (const [colour, alpha] of found.values()) assert.deepEqual([colour, alpha], [red, 255]);
  }
}

// Between two rows, both have their share; the shares of lines side by side add up.
assert.deepEqual(seen(drawn(lines([[2.5, 6.25, 0], [3.5, 6.25, 0], RED]))), new Map([["2,5", [red, 63]], ["2,6", [red, 191]]]));
const filled = Array.from({ length: 60 }, (_, i) => [[2.5, 3 + i / 4, 0], [30.5, 3 + i / 4, 0], RED]);
const surface = seen(drawn(lines(...filled)));
for (let y = 4; y < 16; y++) for (let x = 3; x < 30; x++) assert.deepEqual(surface.get(`${x},${y}`), [red, 255]);

// Whatever the order, the nearer line is seen: z is up, and the camera is above.
const [low, high] = [[[2.5, 5.5, -20], [30.5, 5.5, -20], RED], [[10.5, 2.5, 20], [10.5, 20.5, 20], GREEN]];
for (const order of [[low, high], [high, low]]) {
  const found = seen(drawn(lines(...order)));
  assert.equal(found.get("10,5")[0], word(GREEN) & 0xffffff);
  assert.equal(found.get("11,5")[0], red);
}

// A line that rises through another is behind it first, and then before it.
const rising = seen(drawn(lines([[2.5, 5.5, -20], [30.5, 5.5, 20], RED], ...[6, 26].map((x) => [[x + 0.5, 2.5, 0], [x + 0.5, 20.5, 0], GREEN]))));
assert.deepEqual(["6,5", "26,5"].map((at) => rising.get(at)[0]), [word(GREEN) & 0xffffff, red]);

// At the edge, the share of a pixel that is outside goes nowhere.
const edge = seen(drawn(lines([[39.75, 2.5, 0], [39.75, 9.5, 0], RED])));
assert.deepEqual([...edge.keys()], [2, 3, 4, 5, 6, 7, 8].map((y) => `39,${y}`));

// A kind that is not asked for is not drawn, and rapids let what is behind them through.
const path = { points: [2.5, 5.5, 0, 9.5, 5.5, 0, 9.5, 9.5, 0], origin: [0, 0, 0], kinds: [0, 1, 2], colours: [0, word(RED, 100), word(GREEN)] };
assert.deepEqual([...seen(drawn(path, RAPIDS)).values()], Array(7).fill([red, 100]));
assert.deepEqual([...seen(drawn(path)).keys()], ["9,5", "9,6", "9,7", "9,8"]);
const mixed = drawn(lines([[5.5, 2.5, 0], [5.5, 9.5, 0], GREEN]));
mixed.draw(path, RAPIDS, 0, 3);
assert.deepEqual(seen(mixed).get("5,5"), [word((100 << 16) | (155 << 8)) & 0xffffff, 255]);

// A long way of short lines: in parts as at once, every pixel of it there, and nothing outside.
let seed = 1;
const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
const count = 600;
const way = { points: new Float32Array(3 * count), origin: [20, 15, 0], kinds: new Uint8Array(count).fill(2), colours: new Uint32Array(count).fill(word(RED)) };
way.kinds[0] = 0;
for (let i = 1; i < count; i++) {
  for (let k = 0; k < 3; k++) {
    const to = way.points[3 * i + k - 3] + 4 * random() - 2;
    way.points[3 * i + k] = Math.max(-22, Math.min(22, to));
  }
}
const whole = drawn(way);
const parts = raster();
for (let at = 0; at < count;) at = parts.draw(way, CUTS, at, Math.min(count, at + 1 + Math.floor(40 * random())));
assert.deepEqual(parts.pixels, whole.pixels);
assert.deepEqual(parts.depths, whole.depths);
// Of each line that is longer than a pixel, the pixel of its middle, or a neighbour, is there.
const isSeen = (x, y) => [-1, 0, 1].some((dx) => [-1, 0, 1].some((dy) => whole.pixels[(y + dy) * WIDTH + x + dx] !== 0));
let inside = 0;
for (let i = 1; i < count; i++) {
  const middle = [0, 1].map((k) => Math.floor(way.origin[k] + (way.points[3 * i + k - 3] + way.points[3 * i + k]) / 2));
  const length = [0, 1].map((k) => Math.abs(way.points[3 * i + k] - way.points[3 * i + k - 3]));
  if (middle[0] < 1 || middle[1] < 1 || middle[0] >= WIDTH - 1 || middle[1] >= HEIGHT - 1) continue;
  if (Math.max(...length) < 1.5) continue;
  inside += 1;
  assert.ok(isSeen(...middle), `nothing near ${middle}`);
}
assert.ok(inside > 100, `${inside} lines`);
assert.ok(whole.pixels.filter((pixel) => pixel === 0).length > 100);

// Every second point: half of the lines, from the first point to the last.
const zigzag = { points: [2.5, 5.5, 0, 6, 20, 0, 9.5, 5.5, 0], origin: [0, 0, 0], kinds: [0, 2, 2], colours: [0, word(GREEN), word(RED)] };
const coarse = raster();
coarse.draw(zigzag, CUTS, 0, 3, 2);
assert.deepEqual([...seen(coarse).keys()], [2, 3, 4, 5, 6, 7, 8].map((i) => `${i},5`));

// Numbers that are none, and points far outside, draw nothing and end.
for (const far of [NaN, Infinity, -Infinity, 1e30]) {
  const found = seen(drawn(lines([[far, 5.5, 0], [far, 7.5, 0], RED], [[far, far, far], [far, far, far], RED])));
  assert.equal(found.size, 0);
}
const across = seen(drawn(lines([[-1e9, 5.5, 0], [1e9, 5.5, 0], RED])));
assert.deepEqual([...across.keys()], Array.from({ length: WIDTH }, (_, i) => `${i},5`));

// A new picture has nothing of the one before.
whole.clear();
assert.equal(seen(whole).size, 0);
assert.ok(whole.depths.every((depth) => depth === Infinity));
