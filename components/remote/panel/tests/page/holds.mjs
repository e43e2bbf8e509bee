// Holds in words, the entries of the log, and states of machines with and without a task.

import assert from "node:assert/strict";
import { KINDS, canResume, holdMessages, lasting, wordsOf } from "../../page/src/operator/held.js";
import { mayJogBeside, powerOf, progressOf } from "../../page/src/operator/states.js";
import { LANGUAGES, translator } from "../../page/src/texts.js";

const t = translator("en");
const hold = (kind, more = {}) => ({ kind, by: "", number: 0, resumes: false, ends: false, text: "", ...more });

// Each kind has a sentence in each language; others are told in the words of the machine.
for (const [language] of LANGUAGES) for (const kind of KINDS) assert.ok(wordsOf(hold(kind), translator(language)).length > 8, kind);
assert.equal(wordsOf(hold("inhibit", { by: "door" }), t), "The machine inhibits all motion of the path by door: it must become FALSE.");
assert.equal(wordsOf(hold("spindle-stopped", { number: 1 }), t), "Spindle 1 was stopped. Resume starts it again and goes on.");
assert.equal(wordsOf(hold("new", { text: "it waits" }), t), "it waits");

// What ends by itself is no hold for a banner, and the prompt for a tool asks for itself.
const holds = [hold("dwell", { ends: true }), hold("tool", { number: 3 }), hold("paused", { resumes: true })];
assert.deepEqual(lasting({ holds }).map(({ kind }) => kind), ["paused"]);
assert.deepEqual(lasting({}), []);
assert.ok(canResume({ holds }) && !canResume({ holds: holds.slice(0, 2) }) && !canResume({}));

// The log has the begin of each hold and the end of all, but not what was held before the page was opened.
const log = [];
const note = holdMessages({ add: (level, text) => log.push(`${level} ${text}`) }, t);
for (const now of [undefined, [], [hold("lease")], [hold("lease")], [hold("lease"), hold("feed-zero")], [hold("dwell", { ends: true })], []]) note({ holds: now });
assert.deepEqual(log, [
  "warning Held: Control was lost. Resume goes on.", "warning Held: The feed override is 0 %: raise it.", "info Nothing is held any more.",
]);
log.length = 0;
const late = holdMessages({ add: (level) => log.push(level) }, t);
late({ holds: [hold("lease")] });
assert.deepEqual(log, []);

for (const [task, motion, power, progress, mayJog] of [
  [{ state: 0, interpreter: 0 }, { enabled: true }, "estop", 0, true],
  [{ state: 2, interpreter: 2 }, { queue: 3 }, "on", 2, true],
  [{ state: 2, interpreter: 1 }, {}, "on", 1, false],
  // Without a task motion tells it.
  [{}, { estop: true, enabled: false, queue: 0 }, "estop", 0, true],
  [{}, { estop: false, enabled: false, queue: 0 }, "off", 0, true],
  [{}, { estop: false, enabled: true, queue: 2, paused: false }, "on", 1, false],
  [{}, { estop: false, enabled: true, queue: 2, paused: true }, "on", 2, true],
  [{}, {}, "none", 0, true],
]) assert.deepEqual([powerOf(task, motion), progressOf(task, motion), mayJogBeside(task, motion)], [power, progress, mayJog], JSON.stringify([task, motion]));
