// Probing: a straight move until the probe touches, and the zero of the work set from the place of the touch.

import { card, el, enable, field, setText } from "../dom.js";
import { AXES } from "../format.js";
import { holdButton } from "../hold.js";

/** G codes of the task, times ten. */
const INCH = 200;
const INCREMENTAL = 910;

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
    const before = store.get("task").g_codes ?? [];
    const index = AXES.indexOf(axis.toLowerCase());
    const units = isInch ? "G20" : "G21";
    setText(state, t("probe.moves"));
    // A move without a touch is an error of G38.2: the command then fails, and the message says why.
    const isFound = await run("mdi", { text: `${units} G91 G38.2 ${axis}${way * far} F${speed}` });
    if (isFound) {
      // The place of the touch gets the value, not that at which the move has braked.
      const place = `${-way * tip} + #<_${axis.toLowerCase()}> - #506${index + 1}`;
      const isSet = await run("mdi", { text: `${units} G10 L20 P0 ${axis}[${place}]` });
      setText(state, isSet ? `${t("probe.found")} ${axis} ${-way * tip} ${unit.unit("x")}` : "");
    } else setText(state, t("probe.missed"));
    // What the lines changed is as it was.
    await run("mdi", { text: `${before.includes(INCH) ? "G20" : "G21"} ${before.includes(INCREMENTAL) ? "G91" : "G90"}` });
  }

  store.listen(() => {
    const task = store.get("task");
    const may = ctx.mayMove() && task.state === 2 && !task.interpreter && store.get("motion").all_homed;
    for (const button of buttons) enable(button, may);
  }, signal);
  return card(
    "probe", t("probe"),
    el("div", { class: "row" }, field(t("probe.distance"), distance, unit.unit("x")), field(t("probe.feed"), feed, `${unit.unit("x")}/min`),
      field(t("probe.radius"), radius, unit.unit("x"))),
    el("div", { class: "row", role: "group", "aria-label": t("probe") }, ...buttons), state,
  );
}
