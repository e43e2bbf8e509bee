// Tools, a comparison, and pins of kinematics, for scripts that need them.

import assert from "node:assert/strict";

export const flat = (diameter) => ({ radius: diameter / 2, isBall: false });
export const ball = (diameter) => ({ radius: diameter / 2, isBall: true });

export function near(found, wanted, tolerance) {
  assert.ok(Math.abs(found - wanted) <= tolerance, `${found} instead of ${wanted} ± ${tolerance}`);
}

/** Returns the records of pins and parameters, as the server lists them, for kinematics of this type. */
export const records = (name, values, type = 0) => [
  ...Object.entries(values).map(([pin, float]) => ({ name: `${name}.${pin}`, value: { float } })),
  ...[0, 1, 2].map((n) => ({ name: `kinstype.is-${n}`, value: { bit: n === type } })),
];
