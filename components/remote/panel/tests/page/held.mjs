// Jogs of the page without a browser: what ends a held jog, and when a pulse is answered. Run by `tests/page.rs`.

import assert from "node:assert/strict";

class Node extends EventTarget {
  constructor() {
    super();
    Object.assign(this, { children: [], dataset: {}, style: { setProperty() {} }, disabled: false, hidden: false, isConnected: true, value: "" });
    this.attributes = new Map();
    this.names = new Set();
    this.classList = { add: (n) => this.names.add(n), remove: (n) => this.names.delete(n), toggle() {} };
  }
  append(...nodes) { this.children.push(...nodes.filter((n) => n instanceof Node)); }
  prepend(...nodes) { this.append(...nodes); }
  setAttribute(name, value) { this.attributes.set(name, value); }
  getAttribute(name) { return this.attributes.get(name) ?? null; }
  querySelectorAll() { return this.children; }
  matches() { return false; }
}
globalThis.window = new EventTarget();
globalThis.Element = Node;
globalThis.document = Object.assign(new EventTarget(), {
  hidden: false, body: new Node(),
  createElement: () => new Node(),
  createTextNode: () => null,
});
globalThis.MutationObserver = class { observe() {} };

const { areJogsHeld, releaseAll, watchHold } = await import("../../page/src/hold.js");
const { Jogger, watchKeys } = await import("../../page/src/operator/jog.js");

// Time of its own, which goes on only here.
let now = 0;
let timers = [];
globalThis.setTimeout = (call, ms = 0) => {
  timers.push({ at: now + ms, call });
  return timers.at(-1);
};
globalThis.clearTimeout = (timer) => { timers = timers.filter((other) => other !== timer); };
async function pause(ms) {
  const end = now + ms;
  for (;;) {
    await new Promise((resolve) => { setImmediate(resolve); });
    const [next] = timers.filter((timer) => timer.at <= end).sort((a, b) => a.at - b.at);
    if (!next) break;
    clearTimeout(next);
    now = next.at;
    next.call();
  }
  now = end;
}
const event = (type, fields) => Object.assign(new Event(type, { cancelable: true }), { button: 0, pointerId: 1, repeat: false }, fields);
const item = { name: "X", axis: "x", target: { axis: "X" } };
const other = { name: "Y", axis: "y", target: { axis: "Y" } };

let given = [];
let answer = true;
const ctx = { manual: async () => true, run: async (name) => { given.push(name); return answer; }, info: { linear_units: "mm" } };
const jogger = Object.assign(new Jogger(ctx), { step: () => "0", speed: () => 10 });
watchKeys(jogger, () => [item, other], { isOn: () => true, end() {}, signal: new AbortController().signal });
const press = async (type, key) => {
  window.dispatchEvent(event(type, { key }));
  await pause(0);
};
const taken = () => given.splice(0);

// A key's release ends its jog, also if Shift has changed what the key is called.
await press("keydown", "ArrowRight");
assert.deepEqual(taken(), ["jog"]);
assert.ok(areJogsHeld());
await press("keyup", "ArrowRight");
assert.deepEqual(taken(), ["jog-stop"]);
for (const key of ["Shift", "Control", "a"]) {
  await press("keydown", "ArrowUp");
  await press("keydown", key);
  assert.deepEqual(taken(), ["jog", "jog-stop"], key);
}
await press("keydown", "ArrowUp");
await press("keyup", "Shift");
assert.deepEqual(taken(), ["jog", "jog-stop"]);

// A button: the release, another key, and the removal of the button end the jog.
const button = new Node();
let ends = 0;
watchHold(button, { delay: 0, begin: () => jogger.begin(item, 1, () => button.isConnected), end: () => { ends += 1; jogger.end(item); } });
const hold = async () => {
  button.dispatchEvent(event("pointerdown"));
  await pause(5);
  assert.deepEqual(taken(), ["jog"]);
};
await hold();
button.dispatchEvent(event("keydown", { key: "Shift" }));
assert.deepEqual(taken(), ["jog-stop"]);
button.dispatchEvent(event("keydown", { key: "Enter" }));
await pause(5);
button.dispatchEvent(event("keyup", { key: "Process" }));
assert.deepEqual(taken(), ["jog", "jog-stop"]);
await hold();
releaseAll();
assert.deepEqual(taken(), ["jog-stop"]);
await pause(0);
assert.ok(areJogsHeld());
await hold();
button.isConnected = false;
assert.ok(!areJogsHeld(), "a pulse is answered though nothing holds the jog");
assert.deepEqual(taken(), ["jog-stop"]);
await pause(0);
assert.ok(areJogsHeld(), "the machine has ended the jog");
button.isConnected = true;
releaseAll();
taken();

// A refused stop is followed by silence, which ends the jog.
answer = false;
await press("keydown", "ArrowRight");
await press("keyup", "ArrowRight");
assert.ok(!areJogsHeld());
await pause(250);
assert.ok(areJogsHeld());
answer = true;
taken();

// A touch while the button was disabled does not make it deaf.
button.disabled = true;
button.dispatchEvent(event("pointerdown", { pointerId: 7 }));
button.dispatchEvent(event("pointerup", { pointerId: 7 }));
button.disabled = false;
await hold();
button.dispatchEvent(event("pointerup"));
assert.deepEqual(taken(), ["jog-stop"]);
assert.equal(ends, 5);
