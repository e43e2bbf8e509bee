// Lines that the page's probing gives, messages of the machine, and paths over the camera's picture. Run by `tests/page.rs`.

import assert from "node:assert/strict";

globalThis.window = new EventTarget();
globalThis.document = new EventTarget();

const { probeLines } = await import("../../page/src/operator/probe.js");
const { figures } = await import("../../page/src/align/camera.js");
const { Units } = await import("../../page/src/format.js");
const { workPose } = await import("../../page/src/frame.js");
const { machineMessages } = await import("../../page/src/operator/messages.js");

const mm = { far: 10, speed: 50, tip: 2, isInch: false };
const cases = [
  // Axis, way, numbers, codes in force: the two lines and the value.
  ["X", 1, mm, [210, 900], "G38.2 X[#<_x> + 10.000000] F50.000000", "G10 L20 P0 X[-2.000000 + #<_x> - #5061]", -2],
  ["Y", -1, mm, [210, 910], "G38.2 Y-10.000000 F50.000000", "G10 L20 P0 Y[2.000000 + #<_y> - #5062]", 2],
  ["Z", -1, mm, [210, 900], "G38.2 Z[#<_z> - 10.000000] F50.000000", "G10 L20 P0 Z[0.000000 + #<_z> - #5063]", 0],
  ["X", 1, { ...mm, far: 25.4, speed: 254, tip: 0 }, [200, 900], "G38.2 X[#<_x> + 1.000000] F10.000000", "G10 L20 P0 X[0.000000 + #<_x> - #5061]", 0],
  ["X", 1, { ...mm, far: 1, speed: 2, isInch: true }, [210, 910], "G38.2 X25.400000 F50.800000", "G10 L20 P0 X[-50.800000 + #<_x> - #5061]", -2],
];
for (const [axis, way, numbers, codes, ...lines] of cases) assert.deepEqual(probeLines(axis, way, numbers, codes), lines);
assert.deepEqual(probeLines("X", 1, mm, [70, 210, 900]), []);

// The part is turned by 90°, G92 with it; the tool is 5 long, and A has offsets of its own.
const turned = { g5x_offset: [10, 20, 0, 10], g92_offset: [1, 0, 0, 5], rotation: 90, tool_offset: [0, 0, 5] };
workPose({ pose: [7, 23, 9, 30] }, turned).forEach((v, i) => assert.ok(Math.abs(v - [2, 3, 4, 15][i]) < 1e-9, `${i}: ${v}`));
assert.deepEqual(workPose({ pose: [1, 2, 3] }, {}), [1, 2, 3]);
assert.deepEqual(workPose({}, turned), []);

const shown = [];
const take = machineMessages({ add: (level, text) => shown.push(`${level}: ${text}`) }, (key, n) => `${key} ${n}`);
const state = (messages, message, level) => take({ messages, message, message_level: level });
take({});
state(3, "before the page", 1);
state(3, "before the page", 1);
state(4, "a limit", 1);
state(5, "a limit", 1);
state(8, "a word", 0);
state(0, "", 0);
state(1, "anew", 0);
assert.deepEqual(shown, ["error: a limit", "error: a limit", "warning: messages.missed 2", "info: a word", "info: anew"]);

// The camera's picture is in millimetres, whatever the unit of the machine.
globalThis.Path2D = class {
  drawn = [];
  moveTo(x, y) {
    this.drawn.push("from", x, y);
  }
  lineTo(x, y) {
    this.drawn.push("to", x, y);
  }
};
const path = { count: 4, points: [0, 0, 9, 1, 0, 9, 1, 1, 9, 0, 1, 9], origin: [1, 2, 3], kinds: [0, 1, 2, 2] };
for (const [unit, by] of [["mm", 1], ["inch", 25.4]]) {
  const { cuts, rapids } = figures(path, new Units(unit, "mm"));
  assert.deepEqual(rapids.drawn, ["from", by, 2 * by, "to", 2 * by, 2 * by]);
  assert.deepEqual(cuts.drawn, ["from", 2 * by, 2 * by, "to", 2 * by, 3 * by, "to", by, 3 * by]);
}
