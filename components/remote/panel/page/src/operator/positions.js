// Positions of the tool and of the joints.

import { card, el, setText } from "../dom.js";
import { AXES } from "../format.js";
import { workPose } from "../frame.js";

const KINDS = ["work", "machine", "joint", "togo"];

/** Makes the card of positions. */
export function positionsCard(ctx) {
  const { info, store, t, prefs, signal } = ctx;
  const axes = [...info.axes.toLowerCase()];
  const joints = Array.from({ length: info.joints }, (_, j) => j);
  const rows = el("tbody");
  const system = el("span", { class: "chip" });
  const speed = el("output", { "aria-label": t("velocity") });
  const kinds = KINDS.map((kind) =>
    el("button", { type: "button", "data-kind": kind, onclick: () => prefs.set("position", kind) }, t(`position.${kind}`)),
  );
  const units = el("button", { type: "button", onclick: () => prefs.set("units", ctx.units().name === "mm" ? "inch" : "mm") });
  let shown = "";

  const draw = () => {
    const [motion, task, kind] = [store.get("motion"), store.get("task"), prefs.get("position")];
    const unit = ctx.units();
    for (const button of kinds) button.setAttribute("aria-pressed", String(button.dataset.kind === kind));
    setText(units, unit.name);
    units.setAttribute("aria-label", `${t("units")}: ${unit.name}`);
    setText(system, systemName(task.system));
    setText(speed, `${unit.text(motion.velocity ?? NaN)} ${unit.unit("x")}/s`);
    const want = `${kind} ${unit.name}`;
    if (want !== shown) {
      shown = want;
      rows.replaceChildren(...names(kind, axes, joints, t).map(([label]) => row(label)));
    }
    values(kind, axes, joints, motion, task).forEach(([value, axis, note], i) => {
      const [, number, mark] = rows.children[i].children;
      setText(number, unit.text(value, axis));
      setText(mark, note === "homed" ? "⌂" : unit.unit(axis));
      mark.title = note === "homed" ? t("homed") : "";
    });
  };
  store.listen(draw, signal);
  prefs.listen(draw, signal);
  return card(
    "positions", t("positions"),
    el("div", { class: "row tabs", role: "group", "aria-label": t("positions") }, ...kinds, units),
    el("table", { class: "dro", "aria-label": t("positions") }, rows),
    el("p", { class: "row spread" }, system, el("span", {}, t("velocity"), " ", speed)),
  );
}

/** Returns the name of a coordinate system by its number. */
export function systemName(number) {
  if (!number) return "";
  return number <= 6 ? `G${53 + number}` : `G59.${number - 6}`;
}

function names(kind, axes, joints, t) {
  if (kind === "joint") return joints.map((j) => [`J${j}`]);
  if (kind === "togo") return [[t("togo")]];
  return axes.map((axis) => [axis.toUpperCase()]);
}

function row(label) {
  return el("tr", {}, el("th", { scope: "row" }, label), el("td", { class: "number" }), el("td", { class: "unit" }));
}

function values(kind, axes, joints, motion, task) {
  if (kind === "joint") {
    return joints.map((j) => [motion.joint_feedback?.[j], "x", motion.joint_homed?.[j] ? "homed" : ""]);
  }
  if (kind === "togo") return [[motion.distance_to_go, "x", ""]];
  const pose = kind === "work" ? workPose(motion, task) : (motion.pose ?? []);
  return axes.map((axis) => [pose[AXES.indexOf(axis)], axis, ""]);
}
