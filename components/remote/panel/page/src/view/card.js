// The card with the picture: path, limits, zeros, machine, tool, stock.

import { card, el, setText, show } from "../dom.js";
import { AXES } from "../format.js";
import { FreeFrame, frameOf, workPose } from "../frame.js";
import { asMachine, robotOf } from "../robot/state.js";
import { getJson, listPath, programPath, request } from "../http.js";
import { Vector3 } from "../../vendor/three.module.min.js";
import { Gantry, Lathe, Rods, Tool, Trail, lights } from "./bodies.js";
import { cellApart, kinematicsOf, patternsOf } from "./kinematics.js";
import { Path } from "./path.js";
import { simulationPart } from "./simulation.js";
import { View } from "./view.js";

/** Distance, in millimetres, up to which the cell of a file and the machine have the same arm and tool. */
const SAME_CELL_MM = 0.1;
/** Distance, in millimetres, within which points of the planned path are left out. */
const PLANNED_MM = 0.001;
/** How far up the tool both are compared, in millimetres: its direction counts. */
const SHANK_MM = 100;
/** Colours of stock that is uncut, cut, and cut by a rapid move, and of the tool of a simulation. */
const STOCK = { stock: 0xa9845a, cut: 0xe6cfa0, crash: 0xff2a2a, ghost: 0xa974ff };
const COLOURS = {
  dark: { limit: 0x5b7083, grid: 0x2a3846, rapid: 0xe6c34a, tool: 0xff8c42, trail: 0xff5fa2, frame: 0x7a8ea3, part: 0x9fb6cc, ...STOCK },
  light: { limit: 0x7b8c9c, grid: 0xd4dce4, rapid: 0xa87800, tool: 0xd85a00, trail: 0xc2185b, frame: 0x8fa0b0, part: 0x5d7892, ...STOCK },
};

/** Makes the card with the picture. */
export function viewCard(ctx) {
  const { info, store, t, prefs, signal } = ctx;
  const mm = ctx.mm.read(1);
  const colours = COLOURS[prefs.get("theme")];
  const host = el("div", { class: "view", role: "img", "aria-label": t("view.label") });
  const note = el("p", { class: "note", role: "status" });
  const tools = el("div", { class: "row tabs" });
  const box = card("view", t("view"), tools, host, note);
  let view;
  try {
    view = new View(host, colours);
  } catch (error) {
    setText(note, t("view.none", error.message));
    return box;
  }
  host.classList.add("drawn");
  for (const name of ["iso", "top", "front", "side"]) {
    tools.append(el("button", { type: "button", onclick: () => view.look(name) }, t(`view.${name}`)));
  }
  const colourBy = el("button", { type: "button", onclick: () => prefs.set("colourBy", prefs.get("colourBy") === "feed" ? "tool" : "feed") });
  const way = el("button", { type: "button", id: "view-way", hidden: true, onclick: () => prefs.set("way", prefs.get("way") === "planned" ? "programmed" : "planned") });
  tools.append(
    el("button", { type: "button", "aria-label": t("view.in"), onclick: () => view.zoom(1.4) }, "+"),
    el("button", { type: "button", "aria-label": t("view.out"), onclick: () => view.zoom(1 / 1.4) }, "−"),
    el("button", { type: "button", onclick: () => view.fit(true) }, t("view.machine")),
    el("button", { type: "button", onclick: () => view.fit() }, t("view.path")),
    colourBy,
    way,
  );

  const state = { version: undefined, path: null, planned: null, zeros: "", pose: "", kinematics: null, joints: [] };
  let [low, high] = travel(info);
  let machine = null;
  let tool = new Tool(1, colours.tool);
  const trail = new Trail(colours.trail);
  view.live.add(...lights(), trail.node);
  if (low) view.setLimits(low, high);
  const simulation = simulationPart(ctx, {
    host, view, colours, place, kinematics, frame: () => state.path?.frame ?? frameOf(store.get("task")),
    planned: chosen, whyNot: (path) => whyNoStock(path, state.kinematics, ctx),
  });
  box.append(simulation.node);
  build(null);
  // Arms, deltas and machines that tilt say by their pins what they are.
  kinematics().then((found) => {
    if (!found) return;
    if (found.hasParts && !low) view.setReach(...found.reach);
    if (found.hasParts) [low, high] = low ? [low, high] : found.reach;
    build(found);
    if (state.path) simulation.setPath(state.path);
  });

  /** Reads the kinematics anew: the tool may be another, or the type. Without an answer the picture has the tool alone. */
  async function kinematics() {
    try {
      const [pins, params] = await Promise.all(["pins", "params"].map((kind) => getJson(listPath(kind, patternsOf(info)), { signal })));
      const found = kinematicsOf([...pins, ...params], info);
      if (found && state.kinematics) machine?.become?.(found);
      if (found) state.kinematics = found;
    } catch {
      // It stays what it was.
    }
    return state.kinematics;
  }

  /** Draws the machine where a simulation has the tool; with null, where it is. */
  function place(pose) {
    tool.node.visible = !pose;
    const own = state.kinematics;
    // It begins where the machine is.
    if (state.joints.length === 0) state.joints = [...(store.get("motion").joint_feedback ?? [])];
    const joints = pose && own ? own.jointsAt(pose, state.joints) : null;
    // Joints for a place are known where they are the axes, and from the kinematics of some machines.
    if (machine) machine.node.visible = !pose || !own || joints !== null;
    if (joints) state.joints = joints;
    if (pose && machine?.node.visible) machine.move(new Vector3(...pose.tip), joints);
    if (pose) {
      host.dataset.joints = joints ? joints.map((v) => v.toFixed(3)).join(" ") : "";
      return;
    }
    delete host.dataset.joints;
    state.joints = [];
    state.pose = "";
    store.notify();
  }

  function build(kinematics) {
    state.kinematics = kinematics;
    const size = low ? new Vector3(...high).sub(new Vector3(...low)).length() : 100;
    view.live.remove(tool.node);
    if (machine) view.live.remove(machine.node);
    tool = new Tool(size / 25, colours.tool);
    if (kinematics?.hasParts) machine = new Rods(kinematics, size, colours);
    else if (kinematics) machine = null;
    else machine = low ? bodyOf(info, new Vector3(...low), new Vector3(...high), colours) : null;
    view.live.add(tool.node);
    if (machine) view.live.add(machine.node);
    state.pose = "";
    store.notify();
  }

  let loading = null;

  async function load(file) {
    loading?.abort();
    loading = new AbortController();
    const { signal: mine } = loading;
    [state.path, state.planned] = [null, null];
    show(way, false);
    view.setPath(null);
    simulation.setPath(null);
    trail.clear();
    setText(note, "");
    if (!file) return;
    setText(note, t("view.reading"));
    const begun = performance.now();
    try {
      const response = await request("GET", programPath(file, "/path"), { signal: mine });
      const path = new Path(await response.arrayBuffer());
      state.path = path;
      const told = (name) => JSON.parse(decodeURIComponent(response.headers.get(name) ?? "null"));
      const placed = told("X-Ferrule-Frame");
      path.frame = placed && new FreeFrame(placed);
      path.cutters = told("X-Ferrule-Cutters") ?? [];
      const rapid = 60 * (info.max_linear_velocity ?? 100);
      store.merge("program", { share: (line) => path.share(line, rapid) });
      host.addEventListener("complete", () => {
        host.dataset.complete = String(Math.round(performance.now() - begun));
        host.dataset.points = String(path.count);
      }, { once: true });
      draw();
      simulation.setPath(path);
      const problem = response.headers.get("X-Ferrule-Error");
      setText(note, problem ? decodeURIComponent(problem) : summary(path, low, high, ctx));
      await plan(file, mine);
    } catch (error) {
      if (error.name !== "AbortError") setText(note, error.message);
    }
  }
  /** Reads the path that motion plans, where the limits of the axes are known. */
  async function plan(file, signal) {
    if (state.path.frame) return;
    const whole = state.path.isComplete;
    let planned;
    try {
      const response = await request("GET", programPath(file, `/path?planned&tolerance=${PLANNED_MM * mm}`), { signal });
      planned = new Path(await response.arrayBuffer());
    } catch {
      // The programmed path is there all the same.
      return;
    }
    if (planned.count < 2 || planned.isComplete !== whole || signal.aborted) return;
    state.planned = planned;
    show(way, true);
    host.dataset.planned = String(planned.count);
    view.setLayers(state.path, options(), chosen());
  }

  /** Returns the planned path where it is known and chosen, or null. */
  function chosen() {
    return prefs.get("way") === "planned" ? state.planned : null;
  }

  function options() {
    return { rapid: colours.rapid, colourBy: prefs.get("colourBy") };
  }

  function draw() {
    view.setPath(state.path, options(), chosen());
    if (state.path?.count > 1) host.setAttribute("aria-label", `${t("view.label")}: ${note.textContent}`);
  }

  prefs.listen((name) => {
    setText(colourBy, t(`view.by.${prefs.get("colourBy")}`));
    setText(way, t(`view.way.${prefs.get("way")}`));
    if (name === "colourBy" && state.path) draw();
    if (name === "way" && state.path) view.setLayers(state.path, options(), chosen());
  }, signal);
  store.listen(() => {
    const program = store.get("program");
    const [motion, task] = info.isRobot ? asMachine(robotOf(store.get("values"))) : [store.get("motion"), store.get("task")];
    if (program.version !== state.version && (program.lines > 0 || !program.name)) {
      state.version = program.version;
      load(program.name);
    }
    simulation.follow(motion);
    if (!motion.pose) return;
    const zeros = JSON.stringify([task.g5x_offset, task.g92_offset, task.rotation]);
    if (zeros !== state.zeros) {
      state.zeros = zeros;
      view.setZeros([{ point: [0, 0, 0], angle: 0, isCurrent: false }, zero(task)]);
    }
    const pose = motion.pose.join();
    if (pose === state.pose || simulation.isShown()) return;
    state.pose = pose;
    const tip = state.kinematics?.reported(motion);
    // The controlled point is the tip: the tool is longer than the machine's own point by its offset. That of an arm whose
    // joints are axes is where its joints bring it.
    const point = new Vector3(...(tip?.isForward ? tip.tip : motion.pose.slice(0, 3)));
    tool.move(point, tip?.axis);
    trail.add(point);
    machine?.move(point, motion.joint_feedback);
    const work = workPose(motion, task);
    host.title = work.slice(0, 3).map((v, i) => `${AXES[i].toUpperCase()} ${ctx.units().text(v)}`).join("  ");
    view.request();
  }, signal);
  signal.addEventListener("abort", () => {
    loading?.abort();
    view.dispose();
  });
  return box;
}

/** Returns the travel of X, Y and Z as two points, if the INI file states that of any. */
function travel(info) {
  const limits = info.limits?.axes ?? [];
  const of = (axis) => limits.find((l) => l.axis === axis) ?? {};
  const known = ["X", "Y", "Z"].filter((axis) => Number.isFinite(of(axis).min) && Number.isFinite(of(axis).max));
  if (known.length === 0) return [null, null];
  const end = (key) => ["X", "Y", "Z"].map((axis) => (known.includes(axis) ? of(axis)[key] : 0));
  return [end("min"), end("max")];
}

/** Returns the body of a machine whose axes are its joints; others have none yet. */
function bodyOf(info, low, high, colours) {
  // Without an entry in the INI file the machine has no other kinematics than the trivial ones.
  const [kinematics] = (info.kinematics ?? "trivkins").split(" ");
  if (kinematics !== "trivkins") return null;
  if (isLathe(info)) return new Lathe(low, high, colours);
  return info.axes.toUpperCase().startsWith("XYZ") ? new Gantry(low, high, colours) : null;
}

/** Returns whether a machine has the axes of a lathe. */
function isLathe({ axes }) {
  const has = (axis) => axes.toUpperCase().includes(axis);
  return has("X") && has("Z") && !has("Y");
}

/** Returns the zero of the current coordinate system in machine coordinates. */
function zero(task) {
  const frame = frameOf(task);
  return { point: frame.zero, angle: frame.angle, isCurrent: true };
}

/** Returns why a program's stock is not carved, or an empty text. */
export function whyNoStock(path, kinematics, { info, t, mm, units }) {
  if (isLathe(info)) return t("stock.turned");
  if (kinematics && !kinematics.isKnown) return t(kinematics.isUpright ? "stock.joints" : "stock.plane", kinematics.name);
  const apart = cellApart(path, kinematics, SHANK_MM * mm.read(1));
  if (apart > SAME_CELL_MM * mm.read(1)) return t("stock.cell", units().text(apart), units().unit("x"));
  // Where other axes take the part or the tool is known from the kinematics alone.
  return path.others && !kinematics ? t("stock.others", [...path.others].join(" ")) : "";
}

/** Returns the size of a path in words, and whether it leaves the travel. */
function summary(path, low, high, ctx) {
  if (path.count < 2) return ctx.t("view.empty");
  const unit = ctx.units();
  const size = path.high.map((v, i) => unit.text(v - path.low[i])).join(" × ");
  const text = `${ctx.t("view.size")} ${size} ${unit.unit("x")}`;
  const leaves = low && path.low.some((v, i) => v < low[i] - 1e-6 || path.high[i] > high[i] + 1e-6);
  return leaves ? `${text} · ${ctx.t("view.leaves")}` : text;
}
