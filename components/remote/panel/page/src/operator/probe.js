// Probing: a straight move until the probe touches, and the zero of the work set from the place of the touch.

import { card, el, enable, field, setText } from "../dom.js";
import { AXES } from "../format.js";
import { holdButton } from "../hold.js";

/** G codes of the task, times ten. */
const INCH = 200;
const INCREMENTAL = 910;
const DIAMETER = 70;
const MM_PER_INCH = 25.4;

/** Makes the card of probing. */
export function probeCard(ctx) {
  const { info, store, t, run, signal } = ctx;
  const unit = ctx.units();
  const input = (id, value) => el("input", { type: "number", id, min: "0", step: "any", value: String(value) });
  const isInch = unit.name === "inch";
  const distance = input("probe-distance", isInch ? 0.5 : 10);
  const feed = input("probe-feed", isInch ? 2 : 50);
  const radius = input("probe-radius", 0);
  const state = el("p", { class: "note", role: "status", id: "probe-state" });
  const axes = [...info.axes.toUpperCase()].filter((axis) => "XYZ".includes(axis));
  const ways = axes.flatMap((axis) => (axis === "Z" ? [-1] : [-1, 1]).map((way) => [axis, way]));
  const buttons = ways.map(([axis, way]) => {
    const name = `${axis}${way < 0 ? "−" : "+"}`;
    return holdButton(name, t("hold.hint"), () => probe(axis, way), { "aria-label": `${t("probe")} ${name}`, id: `probe-${axis}-${way < 0 ? "minus" : "plus"}` });
  });

  async function probe(axis, way) {
    const [far, speed, tip] = [distance, feed, radius].map((node) => Number(node.value));
    if (!(far > 0) || !(speed > 0) || !(tip >= 0)) return setText(state, t("probe.numbers"));
    if (!(await ctx.mode("mdi"))) return;
    const [move, zero, value] = probeLines(axis, way, { far, speed, tip, isInch }, store.get("task").g_codes ?? []);
    if (!move) return setText(state, t("probe.diameter"));
    setText(state, t("probe.moves"));
    // A move without a touch is an error of G38.2: the command then fails, and the message says why. Nothing follows a failure.
    if (!(await run("mdi", { text: move }))) return setText(state, t("probe.missed"));
    const isSet = await run("mdi", { text: zero });
    setText(state, isSet ? `${t("probe.found")} ${axis} ${value} ${unit.unit("x")}` : "");
  }

  store.listen(() => {
    const task = store.get("task");
    const may = ctx.hasTask() && ctx.mayMove() && ctx.isOn() && !task.interpreter && store.get("motion").all_homed;
    for (const button of buttons) enable(button, may);
  }, signal);
  return card(
    "probe", t("probe"),
    el("div", { class: "row" }, field(t("probe.distance"), distance, unit.unit("x")), field(t("probe.feed"), feed, `${unit.unit("x")}/min`),
      field(t("probe.radius"), radius, unit.unit("x"))),
    el("div", { class: "row", role: "group", "aria-label": t("probe") }, ...buttons), state,
  );
}

/**
 * Returns the line that probes and the line that sets the zero, and the value of the place in the unit of the numbers. The lines use
 * the units and distances that are in force, and change neither; diameters are refused.
 */
export function probeLines(axis, way, { far, speed, tip, isInch }, codes) {
  if (codes.includes(DIAMETER)) return [];
  const isProgramInch = codes.includes(INCH);
  const factor = isInch === isProgramInch ? 1 : isInch ? MM_PER_INCH : 1 / MM_PER_INCH;
  const number = (value) => (value * factor).toFixed(6);
  const here = `#<_${axis.toLowerCase()}>`;
  const target = codes.includes(INCREMENTAL) ? number(way * far) : `[${here} ${way < 0 ? "-" : "+"} ${number(far)}]`;
  // A tip touches with its side; along Z it touches with its end, which is the tool's length.
  const value = axis === "Z" || tip === 0 ? 0 : -way * tip;
  // The place of the touch gets the value, not that at which the move has braked.
  const place = `[${number(value)} + ${here} - #506${AXES.indexOf(axis.toLowerCase()) + 1}]`;
  return [`G38.2 ${axis}${target} F${number(speed)}`, `G10 L20 P0 ${axis}${place}`, value];
}
