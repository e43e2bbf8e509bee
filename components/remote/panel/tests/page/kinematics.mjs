// Kinematics of the page against those of the machine, which `tests/kinematics.rs` writes to standard input.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

const { records } = await import("./tools.mjs");
const { jointsOf, jointsAlong, configurationOf, tipOf } = await import("../../page/src/view/arm.js");
const { kinematicsOf } = await import("../../page/src/view/kinematics.js");
const { frame } = await import("../../page/src/view/rotation.js");

function near(found, wanted, tolerance, what) {
  assert.equal(found.length, wanted.length, what);
  found.forEach((v, i) => assert.ok(Math.abs(v - wanted[i]) <= tolerance, `${what}: ${found} instead of ${wanted}`));
}

/** Kinematics that have no types. */
const PLAIN = ["maxkins", "lineardeltakins"];
const recordsOf = (name, values, type) => records(name, values, type).filter((record) => !PLAIN.includes(name) || record.name.startsWith(name));

/** Checks a tip by its joints, or the joints by their pose where the tool is upright. */
function checkPlace(own, { joints, pose }, what) {
  if (own.hasTip) {
    const [tip, wanted] = [own.kind.tip(own.values, joints), frame(...pose.slice(0, 6))];
    near(tip.origin, wanted.origin, 1e-9, what);
    near(tip.turn, wanted.turn, 1e-9, what);
    return;
  }
  assert.deepEqual(own.toolAt(pose.slice(0, 3), pose), { tip: pose.slice(0, 3), axis: null }, what);
  const found = own.jointsAt({ letters: pose }, joints);
  assert.ok(found.length > 2, what);
  // Whole turns are none in a picture.
  near(found.map((v, i) => (v - joints[i]) % 360).map((v) => Math.min(Math.abs(v), 360 - Math.abs(v))), found.map(() => 0), 1e-6, what);
  assert.equal(own.jointsAt({ letters: [5000, ...pose.slice(1)] }, joints), null, what);
}

// The INI file says which type is the one of joints, and which axis a joint has.
{
  const told = (type, kinematics) => kinematicsOf(records("xyzac-trt-kins", { "z-offset": 0 }, type), { kinematics: `xyzac-trt-kins ${kinematics}` });
  assert.ok(told(0, "sparm=identityfirst").isJoints && !told(1, "sparm=identityfirst").isJoints && !told(0, "").isJoints);
  assert.deepEqual([told(0, "coordinates=xyzca").letters, told(0, "").letters], ["XYZCA", "XYZAC"]);
}

const counts = { near: 0, same: 0, none: 0 };
for (const { name, type, values, samples } of JSON.parse(readFileSync(0, "utf8"))) {
  const own = kinematicsOf(recordsOf(name, values, type));
  const others = kinematicsOf(recordsOf(name, values, name === "armkins" ? 1 : 1 - type));
  assert.ok(own.isKnown && !own.isJoints && others.isJoints === !PLAIN.includes(name), name);
  samples.forEach((sample, n) => {
    const { joints, pose } = sample;
    const what = `${name} ${n}`;
    if (!sample.axis && !sample.last) {
      checkPlace(own, sample, what);
      return;
    }
    if (name !== "armkins") {
      // Where axes are joints, the tip and the direction are the same.
      const offset = [1, -2, 3];
      const less = (point) => point.map((v, i) => v - offset[i]);
      const told = own.reported({ joint_feedback: joints, tool_offset: [...offset, 0, 0, 0, 0, 0, 0] });
      near(told.tip, less(pose.slice(0, 3)), 1e-9, what);
      near(told.axis, sample.axis, 1e-9, what);
      const posed = own.toolAt(less(pose.slice(0, 3)), pose);
      near(posed.tip, less(pose.slice(0, 3)), 1e-9, what);
      near(posed.axis, sample.axis, 1e-9, what);
      if (!others.isJoints) return;
      const placed = others.toolAt(less(sample.letters.slice(0, 3)), sample.letters);
      near(placed.tip, less(pose.slice(0, 3)), 1e-9, what);
      near(placed.axis, sample.axis, 1e-9, what);
      return;
    }
    const [x, y, z, a, b, c] = pose;
    const tip = frame(x, y, z, a, b, c);
    if (!sample.is_moved) {
      const found = tipOf(values, joints);
      near(found.origin, tip.origin, 1e-9, what);
      near(found.turn, tip.turn, 1e-9, what);
      near(own.reported({ joint_feedback: joints }).axis, own.toolAt([x, y, z], pose).axis, 1e-9, what);
      near(others.toolAt([0, 0, 0], [...joints, 0, 0, 0]).tip, tip.origin, 1e-9, what);
      // Along a path the arm keeps its elbow; the joints bring the tip there.
      const along = jointsAlong(values, tip, joints);
      assert.equal(configurationOf(values, along) & 6, configurationOf(values, joints) & 6, what);
      near(tipOf(values, along).origin, tip.origin, 1e-6, what);
      near(own.jointsAt({ letters: pose }, joints), along, 0, what);
    }
    const found = jointsOf(values, tip, sample.last);
    if (sample.near === null) {
      assert.equal(found, null, what);
      counts.none += 1;
      return;
    }
    assert.ok(found, what);
    // Where the arm is singular, rounding decides among joints that bring the tip to the same place.
    near(tipOf(values, found).origin, tip.origin, 1e-6, what);
    const far = (joint) => Math.max(...joint.map((v, i) => Math.abs(v - sample.last[i])));
    const isStraight = Math.abs(joints[4]) < 1e-6;
    assert.ok(Math.abs(far(found) - far(sample.near)) < 1e-6 || isStraight, what);
    // Of two solutions whose farthest joint is the same, either is the nearest.
    const isSame = found.every((v, i) => Math.abs(v - sample.near[i]) < 1e-6);
    assert.ok(isSame || isStraight || Math.abs(far(found) - far(sample.near)) < 1e-9, what);
    counts.near += 1;
    counts.same += isSame ? 1 : 0;
  });
}
assert.ok(counts.near > 5000 && counts.none > 100 && counts.same > 0.95 * counts.near, JSON.stringify(counts));
