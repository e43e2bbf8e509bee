// Tools that turn while they go: programs of machines with rotary axes, of arms, and reports. Run by `tests/page.rs`.

import assert from "node:assert/strict";

const { ball, flat, near, records } = await import("./tools.mjs");
const { bytes } = await import("./bytes.mjs");
const { FreeFrame, Frame } = await import("../../page/src/frame.js");
const { NORMALS, blockFaces, isBlock } = await import("../../page/src/view/blocks.js");
const { Dexels, boxOf } = await import("../../page/src/view/dexels.js");
const { cellApart, kinematicsOf } = await import("../../page/src/view/kinematics.js");
const { Path } = await import("../../page/src/view/path.js");
const { drawRested } = await import("../../page/src/view/stock.js");
const { translator } = await import("../../page/src/texts.js");
const { whyNoStock } = await import("../../page/src/view/card.js");
const { Carver, Player, Poser } = await import("../../page/src/view/player.js");
const { cross, dot } = await import("../../page/src/view/sweep.js");

const block = (most) => new Dexels([0, 0, -30], [100, 40, 0], most);
const path = (points, more) => new Path(bytes(points, more));
/** A bridge mill whose head tilts by B and turns by C. */
const bridge = kinematicsOf(records("5axiskins", { "pivot-length": 250 }));

function player(points, { machine = bridge, stock = block(), tool = ball(8), frame = new Frame(), still = [], more } = {}) {
  const made = path(points, more);
  const poser = new Poser(made, (...place) => machine.toolAt(...place), still, machine.isBent);
  return new Player({ path: made, times: made.timeline(6000), tools: () => tool, stock, frame, poser });
}
const all = (made) => {
  while (!made.isDone) made.play(Infinity, 1e5);
  return made;
};

// A ball turns about its own centre, from one side to the other: the fan that its shank sweeps, the halves of the shank at both
// ends, and the rest of the ball below.
const [R, DEEP] = [4, 15];
const fan = (angle) => 2 * R * DEEP * DEEP * Math.tan(angle) + (Math.PI * R * R * DEEP) / Math.cos(angle)
  + (4 / 3) * R ** 3 * Math.tan(angle) + ((4 / 3) * Math.PI * R ** 3 * (Math.PI - 2 * angle)) / (2 * Math.PI);
const spread = (40 * Math.PI) / 180;
/** Points of the tip while the ball's centre stays; by B the tool leans against X. */
function turns(step, { about = 0, lift = 0 } = {}) {
  const points = [];
  for (let b = -40; b <= 40; b += step) {
    const [s, c] = [Math.sin((b * Math.PI) / 180), Math.cos((b * Math.PI) / 180)];
    const turn = (about * Math.PI) / 180;
    points.push({ at: [50 + R * s * Math.cos(turn), 20 + R * s * Math.sin(turn), lift - DEEP - R * c], kind: points.length ? 2 : 0, further: [0, b, about, 0, 0, 0] });
  }
  return points;
}
{
  const made = all(player(turns(2)));
  assert.equal(made.path.others, "B");
  // Half a cell along the sides of the fan.
  near(made.stock.removed, fan(spread), 0.5 * made.stock.cell * 2 * DEEP * DEEP * Math.tan(spread));
  near(all(player(turns(2), { stock: block(400_000) })).stock.removed, fan(spread), 0.005 * fan(spread));
  // Long steps are cut in small ones: the tip goes along chords, and the ball a little with it.
  near(all(player(turns(20))).stock.removed, fan(spread), 0.03 * fan(spread));
  // In parts it is the same, and no part takes long.
  const parts = player(turns(20));
  let most = 0;
  for (let n = 0; !parts.isDone; n++) {
    parts.play(1e-4, 1000);
    most = Math.max(most, parts.stock.work);
    assert.ok(n < 1e5);
  }
  near(parts.stock.removed, made.stock.removed, 0.02 * made.stock.removed);
  assert.ok(most < 60_000, `${most}`);
  // Turned about Z, and with the length of the tool in its offset, it is as much.
  near(all(player(turns(2, { about: 0.001 }))).stock.removed, made.stock.removed, 0.01 * made.stock.removed);
  near(all(player(turns(2, { lift: 60 }), { more: { changes: [[0, 0, 0, 60]] } })).stock.removed, made.stock.removed, 1e-3 * made.stock.removed);
}

// In the frame of a part that lies anyhow, a tool along the part's Z is upright.
{
  const frame = new FreeFrame([7, -3, 5, 20, -30, 40]);
  const { turn, zero } = frame;
  const column = (k) => [turn[k], turn[3 + k], turn[6 + k]];
  const at = (point) => zero.map((v, i) => v + point.reduce((sum, x, k) => sum + x * column(k)[i], 0));
  const stock = block();
  const carver = new Carver(stock, frame, ({ tip }) => ({ tip: at(tip), axis: column(2) }));
  for (const z of [5, -10]) carver.report({ pose: [0, 0, 0], tip: [50, 20, z] }, flat(8));
  near(stock.removed, 10 * Math.PI * 16, 0.5 * stock.cell * 10 * Math.PI * 8);
  assert.equal(stock.split.size, 0);
  frame.part(at([1, 2, 3])).forEach((v, i) => near(v, i + 1, 1e-12));
}

// C by a full turn comes back to where it began; in between it has cut a cone.
{
  const round = [{ at: [50, 20, -20], kind: 0, further: [0, 30, 0, 0, 0, 0] }, { at: [50, 20, -20], kind: 2, further: [0, 30, 360, 0, 0, 0], feed: 360 }];
  // B does not move: it is where the machine has it.
  const still = [0, 0, 0, 0, 30];
  const stood = all(player([round[0], { ...round[0], kind: 2, at: [50, 20, -19.999] }], { still }));
  const made = player(round, { still });
  // Nothing but C moves, 360 degrees at 360 degrees a minute.
  near(made.times.at(-1), 1, 1e-6);
  made.play(0.25, 1e9);
  near(made.pose.letters[5], 90, 1e-3);
  near(made.pose.axis[0], 0, 1e-3);
  assert.ok(Math.abs(made.pose.axis[1]) > 0.49);
  all(made);
  // The hollow between two cones, 4 wide on either side of the shank's axis, has more than three times the shank.
  assert.ok(made.stock.removed > 3 * stood.stock.removed, `${made.stock.removed} ${stood.stock.removed}`);
}

// A tool that keeps its lean: the pose of the machine tells what the program does not.
{
  const slot = [{ at: [20, 20, 5], kind: 0 }, { at: [20, 20, -10], kind: 2 }, { at: [60, 20, -10], kind: 2 }];
  const puma = kinematicsOf(records("genserkins", { "A-0": 1, "ALPHA-0": 0, "D-0": 0 }));
  const still = [0, 0, 0, 180, 0, 0];
  const down = all(player(slot, { machine: puma, still, tool: flat(8) }));
  near(down.stock.removed, 10 * (40 * 8 + Math.PI * 16), 0.03 * down.stock.removed);
  const leans = all(player(slot, { machine: puma, still: [0, 0, 0, 150, 0, 0], tool: flat(8) }));
  near(leans.pose.axis[1], 0.5, 1e-12);
  near(leans.pose.axis[2], Math.cos(Math.PI / 6), 1e-12);
  assert.ok(leans.stock.removed > 1.1 * down.stock.removed);
  // Its links have no length: it is nowhere near.
  assert.equal(puma.jointsAt(leans.pose, [0, 0, 0, 0, 0, 0]), null);
  const box = boxOf(leans.path, new Frame(), () => flat(8), 0, (i, as) => leans.poser.pose(leans.poser.place(i, as)));
  near(box[0][2], -10 - 4 * Math.sin(Math.PI / 6), 1e-6);
}

// Arms without a closed form are searched from where they were, straight wrists included.
{
  const links = { "A-0": 0, "A-1": 0, "A-2": 450, "A-3": 0, "A-4": 0, "A-5": 0, "D-0": 0, "D-1": 0, "D-2": 0, "D-3": 450, "D-4": 0, "D-5": 85 };
  [0, -1, 0, 1, -1, 1].forEach((quarter, i) => { links[`ALPHA-${i}`] = (quarter * Math.PI) / 2; });
  const own = kinematicsOf(records("genserkins", links));
  const puma = kinematicsOf(records("pumakins", { A2: 400, A3: 50, D3: 100, D4: 400, D6: 100 }));
  for (const machine of [own, puma]) {
    for (let n = 0; n < 200; n++) {
      const angle = (k) => 120 * Math.sin(n * (k + 1.37)) + (k === 2 ? 70 : 0);
      const joints = [0, 1, 2, 3, 4, 5].map((k) => (k === 4 ? 60 + 0.3 * angle(k) : angle(k)));
      const last = joints.map((v, k) => v + 6 * Math.cos(n * (k + 2)));
      const { origin, turn } = machine.kind.tip(machine.values, joints);
      const found = machine.kind.joints(machine.values, { origin, turn }, last);
      assert.ok(found, `${machine.name} ${n}`);
      const back = machine.kind.tip(machine.values, found);
      back.origin.forEach((v, i) => near(v, origin[i], 1e-5));
      back.turn.forEach((v, i) => near(v, turn[i], 1e-7));
    }
    const { origin, turn } = machine.kind.tip(machine.values, [10, -30, 100, 20, 0, 5]);
    const straight = machine.kind.joints(machine.values, { origin: [...origin], turn }, [11, -31, 101, 19, 1, 6]);
    assert.ok(straight && Math.abs(straight[1] + 30) < 1e-3);
    assert.equal(machine.kind.joints(machine.values, { origin: [5000, 0, 0], turn }, [11, -31, 101, 19, 1, 6]), null);
  }
}

// Joints that a path has decide where the tool is, and no other joints are drawn.
{
  const lengths = { A1: 0, A2: 450, A3: 0, D1: 0, D4: 450, D6: 85, config: -1 };
  for (const n of [0, 1, 2, 3, 4, 5]) Object.assign(lengths, { [`offset-${n}`]: 0, [`sign-${n}`]: 1, [`min-${n}`]: -270, [`max-${n}`]: 270 });
  for (const part of ["tool", "frame"]) for (const letter of "xyzabc") lengths[`${part}.${letter}`] = 0;
  const arm = kinematicsOf(records("armkins", lengths));
  const joints = [[0, -45, 135, 0, 90, 0], [10, -45, 135, 0, 80, 5]];
  const points = joints.map((six, i) => ({ at: [1, 2, 3], kind: 2 * i, further: [180, i, 0, 0, 0, 0], joints: six }));
  const made = player(points, { machine: arm, stock: null, frame: null });
  [768.1981, 0, 233.1981].forEach((v, i) => near(made.tip[i], v, 1e-3));
  near(made.pose.axis[2], 1, 1e-9);
  all(made);
  made.pose.joints.forEach((v, i) => near(v, joints[1][i], 1e-4));
  assert.deepEqual(arm.jointsAt(made.pose, joints[0]), made.pose.joints);

  // The cell of the file is that of the machine, or it is not: at any of its points, and by the direction of the tool alone.
  const straight = joints[0];
  const { origin: there } = arm.kind.tip(arm.values, straight);
  const cell = (turn) => path([0, 1].map((n) => ({ at: there, kind: 2 * n, further: [0, n * turn + 180, 0, 0, 0, 0], joints: straight })));
  const [same, other] = [cell(0), cell(0.2)];
  near(cellApart(same, arm, 100), cellApart(same, arm, 0), 1e-3);
  near(cellApart(same, arm, 0), 0, 1e-3);
  near(cellApart(other, arm, 100), 100 * ((0.2 * Math.PI) / 180), 1e-2);
  assert.equal(cellApart(other, null, 100), 0);
  // A tool that is bent has its tip where a straight one has it, and another direction.
  const bend = kinematicsOf(records("armkins", { ...lengths, "tool.z": 200, "tool.b": 30 }));
  const { origin: end } = bend.kind.tip(bend.values, straight);
  const leaning = (b) => path([0, 2].map((kind) => ({ at: end, kind, further: [180, b, 0, 0, 0, 0], joints: straight })));
  near(cellApart(leaning(30), bend, 100), 0, 1e-3);
  near(cellApart(leaning(0), bend, 0), 0, 1e-3);
  near(cellApart(leaning(0), bend, 100), 200 * Math.sin(Math.PI / 12), 1e-2);

  // A tool's offset (G43) is on the pose, whatever the joints are: program, reports and picture mean the same tip.
  const offset = [0, 0, 50];
  const told = arm.reported({ joint_feedback: joints[0], tool_offset: offset });
  const { origin } = arm.kind.tip(arm.values, joints[0]);
  told.tip.forEach((v, i) => near(v, origin[i] - offset[i], 1e-9));
  assert.ok(!told.isForward);
  const letters = [...origin, 180, 0, 0, 0, 0, 0];
  told.tip.forEach((v, i) => near(v, arm.toolAt(origin.map((p, k) => p - offset[k]), letters).tip[i], 1e-9));

  // Where the axes are the joints, one axis takes the tip round: it is carved along the arc, not along its chord.
  const bent = kinematicsOf(records("armkins", lengths, 1));
  assert.ok(bent.isBent && !arm.isBent && bridge.isKnown && !bridge.isBent);
  const still = [0, -45, 135, 0, 90, 0];
  const swing = [-6, 6].map((at, n) => ({ at: [at, -45, 135], kind: 2 * n, feed: 600 }));
  const reach = bent.reported({ joint_feedback: still }).tip;
  assert.ok(bent.reported({ joint_feedback: still, tool_offset: offset }).isForward);
  const stock = new Dexels([reach[0] - 40, -120, reach[2] - 5], [reach[0] + 20, 120, reach[2] + 5]);
  const cut = player(swing, { machine: bent, still, stock, tool: flat(8) });
  const radius = reach[0];
  while (!cut.isDone) {
    cut.play(1e-4, 1e5);
    near(Math.hypot(cut.tip[0], cut.tip[1]), radius, 1e-3);
  }
  const [arc, rise] = [(radius * 12 * Math.PI) / 180, 5];
  near(stock.removed, rise * (arc * 8 + Math.PI * 16), 0.03 * stock.removed);
  // The middle of the arc is cut, the middle of the chord is not: they are 4 mm apart.
  const at = (x, y) => stock.heights[Math.floor((y - stock.low[1]) / stock.dy) * stock.nx + Math.floor((x - stock.low[0]) / stock.dx)];
  near(at(radius + 3, 0), reach[2], 1e-6);
  near(at(radius - 5, 0), stock.high[2], 0);

  // A scara whose axes are its joints has no tip for a pose: its stock is refused.
  const scara = (type) => kinematicsOf(records("scarakins", { D1: 1, D2: 1, D3: 1, D4: 1, D5: 1, D6: 1 }, type));
  assert.ok(scara(0).isKnown && !scara(1).isKnown && !scara(2).isKnown);
  const ctx = { info: { axes: "XYZABC" }, t: translator("en"), mm: { read: (v) => v } };
  for (const [type, text] of [[0, ""], [1, "X Y Z of scarakins are joints now: stock is not simulated"], [2, "X Y Z of scarakins are joints now: stock is not simulated"]]) {
    assert.equal(whyNoStock(path(swing), scara(type), ctx), text);
  }
  assert.match(whyNoStock(path(swing), kinematicsOf(records("xyzacb_trsrn", { "nut-angle": 45 }, 2)), ctx), /^X Y Z of xyzacb_trsrn are along the tool now/);
}

// The machine carves from report to report while its tool turns.
{
  const stock = block();
  const motion = (b) => {
    const [s, c] = [Math.sin((b * Math.PI) / 180), Math.cos((b * Math.PI) / 180)];
    const tip = [50 + R * s, 20, -DEEP - R * c];
    // The joints that put the tip there.
    const joints = [tip[0] - 250 * s, tip[1], tip[2] - 250 + 250 * c, b, 0, 0];
    return { pose: [...tip, 0, b, 0, 0, 0, 0], joint_feedback: joints, motion_type: 2, segment: 1 };
  };
  const told = bridge.reported(motion(30));
  near(told.tip[0], 50 + R / 2, 1e-9);
  near(told.axis[0], -0.5, 1e-9);
  const carver = new Carver(stock, new Frame(), (m) => bridge.reported(m));
  for (let b = -40; b <= 40; b += 8) carver.report(motion(b), ball(2 * R));
  near(stock.removed, fan(spread), 0.03 * fan(spread));
  const { removed } = stock;
  carver.report(motion(40), ball(2 * R));
  carver.lose();
  carver.report(motion(-60), ball(2 * R));
  assert.equal(stock.removed, removed);
}

// However far the tool turns from one report to the next, its way is cut in 48 steps at most, else in those of 0.25 degrees.
{
  let cuts = 0;
  const stock = { cut: () => { cuts += 1; return 0; } };
  const carver = new Carver(stock, new Frame(), ({ lean }) => ({ tip: [0, 0, 0], axis: [Math.sin((lean * Math.PI) / 180), 0, Math.cos((lean * Math.PI) / 180)] }));
  for (const [lean, wanted] of [[0, 0], [0.6, 3], [11, 42], [170, 48], [170, 0]]) {
    cuts = 0;
    carver.report({ pose: [0, 0, 0], lean }, flat(8));
    assert.equal(cuts, wanted, `${lean}`);
  }
}

// A picture that took long rests three times as long; what has changed meanwhile is drawn after it.
{
  let [time, drawn] = [1000, 0];
  const stock = { field: { changed: [5, 9] }, picture: { draw: () => { drawn += 1; time += 100; } } };
  const clock = { now: () => time };
  assert.equal(drawRested(stock, clock), 0);
  time += 50;
  assert.equal(drawRested(stock, clock), 250);
  stock.field.changed = [40, -1];
  assert.equal(drawRested(stock, clock), 0);
  assert.equal(drawn, 1);
  time += 250;
  assert.equal(drawRested(stock, clock), 0);
  assert.equal(drawn, 2);
}

// The faces of columns that are cut below close around what is left of them.
{
  const stock = new Dexels([0, 0, -20], [40, 40, 0], 400);
  stock.cut(flat(8), [60, 20, -10], [10, 20, -10], false, [1, 0, 0]);
  stock.cut(flat(6), [20, 60, -12], [20, -20, -12], false, [0, 1, 0]);
  stock.cut(ball(6), [30, 30, 5], [30, 30, -6], false, [0.36, 0.48, 0.8]);
  const cells = [...stock.marks.keys()];
  const isDrawn = (at) => isBlock(stock, at % stock.nx, Math.floor(at / stock.nx));
  assert.ok(stock.split.size > 0 && cells.some(isDrawn) && !cells.every(isDrawn));
  for (const at of stock.split.keys()) assert.ok(isDrawn(at));
  // Rows by themselves have the faces of all.
  const rows = Array.from({ length: stock.ny }, (_, row) => blockFaces(stock, row, row));
  const shown = blockFaces(stock, 0, stock.ny - 1);
  assert.ok(shown.count > 0);
  assert.equal(rows.reduce((sum, { count }) => sum + count, 0), shown.count);
  assert.deepEqual(rows.flatMap(({ corners }) => [...corners]), [...shown.corners]);
  assert.ok([...shown.columns].every(isDrawn));
  const { count, corners, normals, columns } = blockFaces(stock, 0, stock.ny - 1, () => true);
  assert.equal(normals.length, count);
  assert.equal(corners.length, 12 * normals.length);
  assert.equal(columns.length, normals.length);
  let volume = 0;
  for (let n = 0; n < normals.length; n++) {
    const [a, b, c, d] = [0, 1, 2, 3].map((k) => [...corners.slice(12 * n + 3 * k, 12 * n + 3 * k + 3)]);
    const less = (u, v) => u.map((x, i) => x - v[i]);
    const area = cross(less(c, a), less(d, b)).map((x) => x / 2);
    assert.ok(dot(area, NORMALS[normals[n]]) > 0, "counter-clockwise from outside");
    volume += dot(a, area) / 3;
  }
  near(volume, 40 * 40 * 20 - stock.removed, 1e-6 * volume);
}

// However often it is cut below, a field has a bounded number of pieces, and knows how many.
{
  const stock = new Dexels([0, 0, -40], [40, 40, 0], 400);
  for (let z = -39; z < 0; z += 1) stock.cut(flat(0.5), [60, 20, z], [10, 20, z], false, [1, 0, 0]);
  for (let z = -39; z < -1; z += 1) for (let y = 0; y <= 40; y += 1) stock.cut(flat(0.6), [50, y, z], [-10, y, z], false, [1, 0, 0]);
  const pieces = [...stock.split.values()].reduce((sum, all) => sum + all.length / 2, 0);
  assert.equal(stock.pieceCount, pieces);
  assert.ok(pieces > 2 * 400 && pieces <= 5 * 400, `${pieces}`);
  let left = 0;
  for (let at = 0; at < stock.marks.length; at++) for (const [n, v] of stock.pieces(at).entries()) left += n % 2 ? v : -v;
  near(left * stock.dx * stock.dy, 40 * 40 * 40 - stock.removed, 1e-6 * 64000);
  assert.ok(blockFaces(stock, 0, stock.ny - 1).count <= 8 * (pieces + 400));
}
