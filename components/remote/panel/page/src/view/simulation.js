// Stock in the picture: carved by the machine while it cuts, and by a simulation, in which the machine does not move.

import { el, enable, field as labelled, mark, setText, show } from "../dom.js";
import { getJson, pause } from "../http.js";
import { Dexels, boxInParts } from "./dexels.js";
import { Carver, Player, Poser, tipOf } from "./player.js";
import { INTERPRETER } from "../operator/states.js";
import { Crashes, Cutter, StockPicture, drawRested } from "./stock.js";

/** Margin around a program's cuts, and the diameter of a tool that the table has none for, in millimetres. */
const [MARGIN_MM, DIAMETER_MM] = [2, 6];
/** Time of one picture for cutting, and work between two looks at the clock. */
const [SLICE_MS, SLICE_CELLS] = [15, 4000];
/** Time between two pictures of a simulation that is as fast as possible. */
const PICTURE_MS = 100;
/** Longest step of the clock: a page that was hidden does not leap. */
const STEP_MS = 200;
/** Distance of a machine that has moved, in millimetres. */
const MOVED_MM = 0.02;
const SPEEDS = ["1", "10", "100", "max"];
const SHAPES = ["table", "flat", "ball"];
/** Words of a tool's remark that tell a ball. */
const BALL = /ball|spher|esf[eé]r|bola/i;

/**
 * Makes the controls of stock and simulation. `place` puts the drawn machine to a pose of the tool, or back to where it is
 * with null; `kinematics` reads those of the machine, `frame` returns that of the part; `planned` returns the path that is played
 * in the place of the programmed one, or null; `whyNot` returns why nothing is carved, or an empty text.
 */
export function simulationPart(ctx, { host, view, colours, place, kinematics, frame: frameNow, planned, whyNot }) {
  const { info, link, store, t, prefs, signal } = ctx;
  const mm = ctx.mm.read(1);
  const banner = el("p", { class: "simulated", role: "status", hidden: true });
  host.append(banner);
  const figures = el("p", { class: "note", id: "sim-figures" });
  const warning = el("p", { class: "warned", role: "status", id: "sim-warning", hidden: true });
  const begin = el("button", { type: "button", id: "sim-start", onclick: start }, t("sim.start"));
  const pause = el("button", { type: "button", id: "sim-pause", onclick: () => sim && go(sim.state === "playing" ? "paused" : "playing") }, t("sim.pause"));
  const end = el("button", { type: "button", id: "sim-end", onclick: () => stop() }, t("sim.end"));
  const speed = el("select", { id: "sim-speed", "aria-label": t("sim.speed") },
    ...SPEEDS.map((s) => el("option", { value: s, selected: s === "10" }, t(s === "max" ? "sim.speed.max" : "sim.speed.times", s))));
  const carve = el("button", { type: "button", id: "stock-live", onclick: () => choose({ isLive: !prefs.get("stock").isLive }) }, t("stock.live"));
  const fresh = el("button", { type: "button", id: "stock-new", onclick: () => renew() }, t("stock.new"));
  const choices = fields(ctx, mm, choose);
  const node = el("div", { class: "simulation" },
    el("div", { class: "row tabs", role: "group", "aria-label": t("sim") }, begin, pause, end, speed),
    figures, warning,
    el("details", { id: "stock-more" }, el("summary", {}, t("stock")), el("div", { class: "row" }, carve, fresh), choices.node));

  let path = null;
  let table = [];
  let sim = null;
  let live = null;
  let asked = null;
  let machine = null;
  let resting = 0;
  // What the kinematics were read for, and how often they are being read.
  let [basis, rereads] = ["", 0];
  // Numbers of the latest start and of the latest stock: what is late is dropped.
  let [starts, renewals] = [0, 0];
  const cutter = new Cutter(colours.ghost);
  const crashes = new Crashes(colours.crash);
  cutter.node.visible = false;
  view.live.add(cutter.node, crashes.node);

  function choose(change) {
    prefs.set("stock", { ...prefs.get("stock"), ...change });
    renew();
  }

  /** Returns a tool: its diameter is that of the table, or the one that the operator states. */
  function toolOf(number) {
    const { diameter, shape } = prefs.get("stock");
    const row = [...(path?.cutters ?? []), ...table].find((tool) => tool.number === number);
    const isKnown = row?.diameter > 0;
    const isBall = shape === "table" ? row?.is_ball ?? BALL.test(row?.comment ?? "") : shape === "ball";
    return { number, radius: (isKnown ? row.diameter : diameter ?? DIAMETER_MM * mm) / 2, isBall, isKnown };
  }

  /** Returns the tools of a number, looked up once. */
  function tools() {
    const known = new Map();
    return (number) => {
      if (!known.has(number)) known.set(number, toolOf(number));
      return known.get(number);
    };
  }

  /** Returns what tells the direction of the tool along the path; null where it is upright by the machine's axes. */
  function poser(of = path) {
    return machine && of ? new Poser(of, (...place) => machine.toolAt(...place), store.get("motion").pose, machine.isBent) : null;
  }

  /** Reads the kinematics as they are now. */
  async function reread() {
    machine = await kinematics();
    if (!signal.aborted) link.watch("kinematics", machine?.types ?? []);
  }

  /** Returns the tip and the direction of the tool that the machine reports. */
  function reported(motion) {
    return machine?.reported(motion) ?? { tip: tipOf(motion), axis: null };
  }

  /** Returns new stock with its picture; null where nothing is carved. */
  async function block() {
    if (!path || path.count < 2 || whyNot(path)) return null;
    const [mine, frame, way] = [path, frameNow(), poser()];
    const box = await boxInParts(rests(), path, frame, tools(), MARGIN_MM * mm, way && ((at, as) => way.pose(way.place(at, as))));
    // It may be that of a program that is no longer shown.
    if (path !== mine) return null;
    choices.propose(box);
    const typed = prefs.get("stock").box;
    const ends = [0, 1].map((side) => [0, 1, 2].map((axis) => typed[side][axis] ?? box?.[side][axis]));
    try {
      const field = new Dexels(...ends);
      return { field, frame, picture: new StockPicture(field, frame, colours) };
    } catch {
      return null;
    }
  }

  function drop(stock) {
    if (!stock) return;
    view.live.remove(stock.picture.node);
    stock.picture.dispose();
  }

  /** Puts new stock in place of what the machine has carved. */
  async function renew() {
    renewals += 1;
    const mine = renewals;
    drop(live);
    live = null;
    draw();
    if (!prefs.get("stock").isLive) return;
    await reread();
    if (mine !== renewals) return;
    basis = basisNow();
    const stock = await block();
    if (mine !== renewals) {
      drop(stock);
      return;
    }
    live = stock;
    if (live) {
      live.carver = new Carver(live.field, live.frame, reported);
      view.live.add(live.picture.node);
    }
    draw();
  }

  async function readTools() {
    asked?.abort();
    asked = new AbortController();
    table = await getJson("/tools", { signal: asked.signal });
    await reread();
  }

  async function start() {
    stop();
    const mine = starts;
    let stock = null;
    try {
      await readTools();
      stock = await block();
      const played = planned() ?? path;
      const times = await played?.timelineInParts(60 * (info.max_linear_velocity ?? 100), rests());
      if (mine !== starts) {
        drop(stock);
        return;
      }
      const player = new Player({ path: played, times, tools: tools(), stock: stock?.field ?? null, frame: stock?.frame ?? null, poser: poser(played) });
      sim = { player, stock, state: "playing", pose: store.get("motion").pose, last: performance.now() };
    } catch (error) {
      drop(stock);
      if (error.name !== "AbortError") setText(figures, path?.count > 1 ? error.message : t("view.empty"));
      return;
    }
    if (sim.stock) view.live.add(sim.stock.picture.node);
    go("playing");
  }

  function go(state) {
    if (!sim || sim.state === "done") return;
    sim.state = state;
    sim.last = performance.now();
    if (state === "playing") again();
    draw();
  }

  /** Ends a simulation: the picture is that of the machine again. */
  function stop(why = "") {
    starts += 1;
    asked?.abort();
    if (!sim) return;
    cancelAnimationFrame(sim.frame);
    clearTimeout(sim.timer);
    drop(sim.stock);
    sim = null;
    place(null);
    draw();
    if (why) setText(figures, why);
  }

  function tick() {
    if (sim?.state !== "playing") return;
    const now = performance.now();
    const passed = Math.min(STEP_MS, now - sim.last) / 60_000;
    sim.last = now;
    const { player } = sim;
    const until = speed.value === "max" ? Infinity : player.time + passed * Number(speed.value);
    // A time that cutting does not reach is left out: the next picture goes on from here.
    while (!player.isDone && player.time < until && performance.now() - now < SLICE_MS) player.play(until - player.time, SLICE_CELLS);
    if (player.isDone) {
      sim.state = "done";
      place(null);
    } else again();
    // As fast as possible, cutting does not wait for pictures: without a graphics processor they take longer than it.
    if (player.isDone || speed.value !== "max" || now - sim.drawn > PICTURE_MS) draw();
  }

  /** Cuts on with the next picture, or, as fast as possible, when the page has answered. */
  function again() {
    cancelAnimationFrame(sim.frame);
    clearTimeout(sim.timer);
    if (speed.value === "max") sim.timer = setTimeout(tick, 0);
    else sim.frame = requestAnimationFrame(tick);
  }

  /** Shows what is known, in picture and words. */
  function draw() {
    const state = sim?.state ?? "";
    if (sim) sim.drawn = performance.now();
    if (sim) host.dataset.simulation = state;
    else delete host.dataset.simulation;
    show(banner, Boolean(sim));
    if (sim) setText(banner, t(state === "done" ? "sim.done" : "sim.still"));
    setText(pause, t(state === "paused" ? "sim.resume" : "sim.pause"));
    setText(begin, t(sim ? "sim.again" : "sim.start"));
    enable(begin, path?.count > 1 && isStill());
    enable(pause, state === "playing" || state === "paused");
    enable(end, Boolean(sim));
    mark(carve, "aria-pressed", prefs.get("stock").isLive);
    enable(fresh, Boolean(live));
    cutter.node.visible = state === "playing" || state === "paused";
    if (cutter.node.visible) {
      const { tip, pose } = sim.player;
      cutter.move(tip, sim.player.tool, pose?.axis);
      place(pose ?? { tip });
    }
    if (live) live.picture.node.visible = !sim;
    const shown = sim?.stock ?? (sim ? null : live);
    drawStock(shown);
    crashes.show(sim?.player.rapids ?? [], sim?.player.path ?? path);
    const rapids = sim ? sim.player.rapidMoves : live?.carver.rapids ?? 0;
    tell(shown, rapids);
    view.request();
  }

  /** Draws the stock, but not without a rest: what has changed meanwhile is drawn after it. */
  function drawStock(shown) {
    clearTimeout(resting);
    const rest = shown ? drawRested(shown) : 0;
    if (rest > 0) resting = setTimeout(draw, rest);
  }

  function tell(shown, rapids) {
    Object.assign(host.dataset, { removed: shown ? String(shown.field.removed) : "", rapids: String(rapids), share: String(sim?.player.share ?? "") });
    show(warning, rapids > 0);
    setText(warning, rapids === 0 ? "" : rapids === 1 ? t("sim.rapid") : t("sim.rapids", rapids));
    const none = path && whyNot(path);
    const parts = [];
    if (sim) {
      const tool = sim.player.tool;
      parts.push(`${Math.floor(100 * sim.player.share)} %`, toolText(tool));
    }
    if (shown) parts.push(t("stock.removed", volume(shown.field.removed)), t("stock.cells", ctx.units().text(shown.field.cell), ctx.units().unit("x")));
    else if (sim || (path && prefs.get("stock").isLive)) parts.push(none || t("stock.none"));
    setText(figures, parts.join(" · "));
  }

  function toolText({ number, radius, isBall, isKnown }) {
    const unit = ctx.units();
    const text = `T${number} ⌀ ${unit.text(2 * radius)} ${unit.unit("x")} ${t(`stock.shape.${isBall ? "ball" : "flat"}`)}`;
    return isKnown ? text : `${text} (${t("stock.assumed")})`;
  }

  function volume(value) {
    const unit = ctx.units();
    const shown = value * unit.show(1) ** 3;
    return `${unit.name === "mm" ? shown.toFixed(1) : shown.toFixed(4)} ${unit.unit("x")}³`;
  }

  function isStill() {
    const [motion, task] = [store.get("motion"), store.get("task")];
    return !task.interpreter && motion.in_position !== false;
  }

  /** Ends a simulation when the machine moves, and shows what it has carved. */
  function follow(motion) {
    if (sim && motion.pose) {
      const from = sim.pose ?? motion.pose;
      const hasMoved = motion.pose.some((v, i) => Math.abs(v - from[i]) > MOVED_MM * mm);
      if (hasMoved || !isStill()) stop(t("sim.moved"));
    }
    const hasCarved = live && !sim && live.field.changed[1] >= 0;
    if (hasCarved || begin.disabled !== !(path?.count > 1 && isStill())) draw();
  }

  /** Carves what the machine cuts, at each of its reports. */
  function cut(part) {
    if (!live) return;
    const task = store.get("task");
    if (basis !== basisNow()) renewKinematics();
    // What happens without a connection is left out; so is what happens without a program, where the machine has a task.
    if (part === "link" || task.interpreter === INTERPRETER.idle || rereads > 0) live.carver.lose();
    else if (part === "motion") {
      live.carver.report(store.get("motion"), toolOf(task.tool ?? loneTool()));
      // A picture may come much later.
      if (!sim) host.dataset.removed = String(live.field.removed);
      host.dataset.reported = String(store.get("motion").time_ns);
    }
  }

  /** Returns tool, offset and type of kinematics as one text: with another, pins of the kinematics may be others. */
  function basisNow() {
    const types = machine?.types.map((name) => store.get("values")[name]);
    return JSON.stringify([store.get("motion").tool_offset, store.get("task").tool, types]);
  }

  /** Reads the kinematics anew; until then it is not known where the tool is. */
  function renewKinematics() {
    basis = basisNow();
    if (!machine) return;
    rereads += 1;
    reread().finally(() => {
      rereads -= 1;
    });
  }

  /** Returns the tool of a machine without a task: the first of the path. */
  const loneTool = () => path?.tools.find((number) => number > 0) ?? 0;

  store.report(cut, signal);
  signal.addEventListener("abort", () => {
    cancelAnimationFrame(sim?.frame);
    clearTimeout(sim?.timer);
    clearTimeout(resting);
    asked?.abort();
    link.watch("kinematics", []);
  });
  draw();
  return {
    node,
    follow,
    /** Returns whether the picture shows a simulation that moves, and not the machine. */
    isShown: () => sim?.state === "playing" || sim?.state === "paused",
    /** Takes over a program's path, or none. */
    async setPath(next) {
      stop();
      path = next;
      choices.propose(null);
      renew();
      if (!path) return;
      await readTools().catch(() => {});
      if (path === next) renew();
    },
  };
}

/** Returns a function that lets the page answer when a part has taken its time. */
function rests() {
  let begun = performance.now();
  return async () => {
    if (performance.now() - begun < SLICE_MS) return;
    await pause(0);
    begun = performance.now();
  };
}

/** Makes the fields of what the operator states: size of the stock, diameter and shape of tools. */
function fields(ctx, mm, choose) {
  const { t, prefs } = ctx;
  const unit = ctx.units();
  const shown = (value) => (Number.isFinite(value) ? String(Number(unit.text(value))) : "");
  const stated = () => prefs.get("stock");
  const read = (input) => (input.value === "" || !Number.isFinite(Number(input.value)) ? null : unit.read(Number(input.value)));
  const inputs = [0, 1].map((side) => [0, 1, 2].map((axis) => el("input", {
    type: "number", step: "any", value: shown(stated().box[side][axis]), id: `stock-${"xyz"[axis]}-${side}`,
    "aria-label": `${"XYZ"[axis]} ${t(side ? "stock.to" : "stock.from")}`,
    onchange: () => choose({ box: inputs.map((row) => row.map(read)) }),
  })));
  const rows = [0, 1, 2].map((axis) => el("div", { class: "row" }, el("span", {}, "XYZ"[axis]), inputs[0][axis], el("span", {}, "–"), inputs[1][axis],
    el("span", { class: "unit" }, unit.unit("x"))));
  const diameter = el("input", {
    type: "number", step: "any", min: 0, id: "stock-diameter", value: shown(stated().diameter ?? DIAMETER_MM * mm),
    onchange: () => choose({ diameter: read(diameter) > 0 ? read(diameter) : null }),
  });
  const shape = el("select", { id: "stock-shape", onchange: () => choose({ shape: shape.value }) },
    ...SHAPES.map((name) => el("option", { value: name, selected: name === stated().shape }, t(`stock.shape.${name}`))));
  return {
    node: el("div", {}, el("p", { class: "note" }, t("stock.size")), ...rows,
      el("div", { class: "row" }, labelled(t("stock.diameter"), diameter, unit.unit("x")), labelled(t("stock.shape"), shape))),
    /** Shows the size that the program needs where none is stated. */
    propose(box) {
      for (const side of [0, 1]) for (const axis of [0, 1, 2]) inputs[side][axis].placeholder = shown(box?.[side][axis]);
    },
  };
}
