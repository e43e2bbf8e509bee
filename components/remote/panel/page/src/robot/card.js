// The run of a robot behind its own controller: connection, program, run, pause, stop.

import { card, el, enable, field, setText, show } from "../dom.js";
import { holdButton } from "../hold.js";
import { getJson } from "../http.js";
import { robotOf, robotState } from "./state.js";

/** Names of files that may be programs. */
const PROGRAM = /\.(anc|cnc|gcode|nc|ngc|tap|txt)$/i;

/** Makes the card. */
export function robotCard(ctx) {
  const { store, t, run, signal } = ctx;
  const state = el("p", { class: "state", role: "status", id: "robot-state" });
  const why = el("p", { class: "note", role: "status", id: "robot-why" });
  const hold = (id, key, action, kind = "") => holdButton(t(key), t("hold.hint"), action, { id, class: kind });
  const connect = hold("robot-connect", "robot.connect", () => run("robot-connect"));
  const reset = hold("estop-reset", "estop.reset", () => run("estop-reset"));
  const disconnect = el("button", { type: "button", id: "robot-disconnect", onclick: () => run("robot-disconnect") }, t("robot.disconnect"));
  const start = hold("robot-run", "robot.run", () => begin(0), "primary");
  const again = hold("robot-again", "robot.again", () => begin(robotOf(store.get("values"))?.line ?? 0));
  const pause = el("button", { type: "button", id: "robot-pause", onclick: () => ctx.stop("robot-pause") }, t("robot.pause"));
  const resume = hold("robot-resume", "robot.resume", () => run("robot-resume"), "primary");
  const stop = el("button", { type: "button", id: "robot-stop", class: "danger", onclick: () => ctx.stop("robot-stop") }, t("robot.stop"));
  const files = el("select", { id: "robot-file" });
  const load = el("button", { type: "button", id: "robot-load", onclick: loadProgram }, t("robot.load"));
  const bar = el("progress", { max: 1, value: 0, "aria-label": t("robot.progress") });
  const cells = Object.fromEntries(["line", "program", "point", "zero", "joints", "speed"].map((name) => [name, el("td", { class: "number", id: `robot-${name}` })]));
  const table = el("table", { class: "grid", "aria-label": t("robot") }, el("tbody", {}, ...Object.entries(cells).map(([name, cell]) =>
    el("tr", {}, el("th", { scope: "row" }, t(`robot.row.${name}`)), cell))));

  function begin(from) {
    // The end of the run is told by the state; a refusal is told at once.
    run("robot-run", { from });
  }

  /** Loads the chosen program; a refusal is a message with its line and point. */
  async function loadProgram() {
    if (files.value && await run("robot-load", { program: files.value })) ctx.messages.add("info", t("robot.loaded", files.value));
  }

  async function refresh() {
    try {
      const all = (await getJson("/programs", { signal })).filter((file) => PROGRAM.test(file.name));
      const chosen = files.value;
      files.replaceChildren(...all.map((file) => el("option", { value: file.name, selected: file.name === chosen }, file.name)));
    } catch (error) {
      if (error.name !== "AbortError") ctx.fail(error);
    }
    draw();
  }

  function draw() {
    const robot = robotOf(store.get("values"));
    const name = ctx.isJoined() ? robotState(robot) : "unknown";
    setText(state, t(`robot.state.${name}`));
    state.dataset.state = name;
    const held = robot?.hold ? t("robot.held") : "";
    setText(why, robot?.stopped ? t(`robot.error.${robot.error}`) : robot?.enable === false ? t("robot.error.2") : held);
    const may = ctx.mayMove() && robot !== null;
    const isFree = may && !robot.busy;
    show(reset, store.get("panel").can_reset === true);
    enable(reset, ctx.mayControl() && robot?.enable === false);
    enable(connect, isFree && !robot.connected && robot.enable === true);
    enable(disconnect, ctx.mayControl() && (robot?.connected === true || robot?.connecting === true) && (!robot.busy || robot.connecting));
    enable(load, ctx.mayControl() && robot?.ready === true && files.value !== "");
    enable(start, isFree && robot.ready && robot.lines > 0);
    enable(again, isFree && robot.ready && robot.line > 0 && robot.line < robot.lines);
    enable(pause, robot?.running === true && ctx.role() !== "viewer");
    enable(resume, may && robot.busy && !robot.running && !robot.connecting);
    enable(stop, robot?.connected === true || robot?.busy === true);
    if (!robot) return;
    const lengths = (list) => list.map((n) => n.toFixed(3)).join("  ");
    const texts = {
      line: `${robot.line} / ${robot.lines}`, program: robot["program-line"] || "—", point: lengths(robot.point), zero: lengths(robot.zero),
      joints: robot.joints.map((n) => n.toFixed(2)).join("  "), speed: robot.speed.toFixed(3),
    };
    for (const [key, text] of Object.entries(texts)) setText(cells[key], String(text));
    bar.value = robot.lines > 0 ? robot.line / robot.lines : 0;
  }
  store.listen(draw, signal);
  refresh();
  return card("robot", t("robot"), state, why, el("div", { class: "row" }, reset, connect, disconnect),
    el("div", { class: "row" }, field(t("robot.program"), files), load, el("button", { type: "button", class: "small", id: "robot-files", onclick: refresh }, t("refresh"))),
    el("div", { class: "row" }, start, pause, resume, stop, again), bar, table);
}
