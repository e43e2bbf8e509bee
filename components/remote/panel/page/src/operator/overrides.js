// Overrides, spindle and coolant.

import { card, el, enable, field, mark, setText } from "../dom.js";
import { holdButton } from "../hold.js";

/** Time in ms between two commands of a slider that is dragged. */
const SEND_MS = 100;

/** Makes the card of overrides. */
export function overridesCard(ctx) {
  const { info, store, t, run, signal } = ctx;
  const feed = override(ctx, "feed-override", t("override.feed"), info.max_feed_override ?? 1.2, (scale) => run("feed-override", { scale }));
  const rapid = override(ctx, "rapid-override", t("override.rapid"), 1, (scale) => run("rapid-override", { scale }));
  const spindles = Array.from({ length: info.spindles ?? 0 }, (_, spindle) =>
    override(ctx, `spindle-override-${spindle}`, label(t("override.spindle"), spindle, info), info.max_spindle_override ?? 1.2,
      (scale) => run("spindle-override", { scale, spindle })),
  );
  store.listen(() => {
    const [motion, task] = [store.get("motion"), store.get("task")];
    feed.draw(motion.feed_override ?? task.feed_override);
    rapid.draw(motion.rapid_override ?? task.rapid_override);
    spindles.forEach((s, i) => s.draw((motion.spindle_override ?? task.spindle_override)?.[i]));
  }, signal);
  return card("overrides", t("overrides"), feed.label, rapid.label, ...spindles.map((s) => s.label));
}

function label(text, spindle, info) {
  return (info.spindles ?? 0) > 1 ? `${text} ${spindle}` : text;
}

function override(ctx, id, name, most, change) {
  const input = el("input", { type: "range", id, min: "0", max: String(Math.round(most * 100)), step: "1", value: "100" });
  const output = el("output", { for: id });
  const full = el("button", { type: "button", class: "small", "aria-label": `${name} 100 %`, onclick: () => change(1) }, "100 %");
  let timer = null;
  let sent = 0;
  const send = () => {
    timer = null;
    sent = performance.now();
    change(Number(input.value) / 100);
  };
  input.addEventListener("input", () => {
    setText(output, `${input.value} %`);
    timer ??= setTimeout(send, Math.max(0, SEND_MS - (performance.now() - sent)));
  });
  const draw = (scale) => {
    enable(input, ctx.mayControl());
    enable(full, ctx.mayControl());
    // A slider that is being dragged is not moved by answers that are on their way.
    if (!Number.isFinite(scale) || timer !== null || performance.now() - sent < 500) return;
    input.value = String(Math.round(scale * 100));
    setText(output, `${input.value} %`);
  };
  return { draw, label: el("div", { class: "slide" }, el("label", { for: id }, name), input, output, full) };
}

/** Makes the card of spindle and coolant. */
export function spindleCard(ctx) {
  const { info, store, t, run, signal } = ctx;
  const count = info.spindles ?? 0;
  const spindles = Array.from({ length: count }, (_, i) => spindle(ctx, i, count > 1 ? `${t("spindle")} ${i}` : t("spindle")));
  const coolants = ["mist", "flood"].map((name) => {
    const button = el("button", { type: "button", id: name, "aria-pressed": "false" }, t(name));
    button.addEventListener("click", () => run(name, { on: button.getAttribute("aria-pressed") !== "true" }));
    return button;
  });
  store.listen(() => {
    const [motion, task] = [store.get("motion"), store.get("task")];
    const may = ctx.mayMove() && ctx.isOn() && !ctx.progress();
    spindles.forEach((s, i) => s.draw(motion, i, may));
    ["mist", "flood"].forEach((name, i) => {
      mark(coolants[i], "aria-pressed", task[name] === true);
      enable(coolants[i], may);
    });
  }, signal);
  return card(
    "spindle", t("spindle.coolant"), ...spindles.flatMap((s) => s.parts),
    el("div", { class: "row", role: "group", "aria-label": t("coolant") }, ...coolants),
  );
}

function spindle(ctx, index, name) {
  const { t, run, info } = ctx;
  const speed = el("input", { type: "number", min: "0", step: "any", value: String(info.ini?.DISPLAY?.DEFAULT_SPINDLE_SPEED ?? 500) });
  const turn = (way) => run("spindle", { spindle: index, speed: way * Number(speed.value) });
  const forward = holdButton("↻", t("hold.hint"), () => turn(1), { "aria-label": `${name}: ${t("spindle.forward")}` });
  const reverse = holdButton("↺", t("hold.hint"), () => turn(-1), { "aria-label": `${name}: ${t("spindle.reverse")}` });
  const stop = el("button", { type: "button", onclick: () => run("spindle", { spindle: index, speed: 0 }) }, t("spindle.stop"));
  const state = el("output", {});
  return {
    parts: [
      el("p", { class: "row spread" }, el("span", {}, name), state),
      el("div", { class: "row" }, field(t("spindle.speed"), speed, t("rpm")), forward, reverse, stop),
    ],
    draw(motion, i, may) {
      const real = (motion.spindle_speed?.[i] ?? 0) * (motion.spindle_override?.[i] ?? 1);
      setText(state, `${real.toFixed(0)} ${t("rpm")}${real !== 0 && motion.at_speed ? " ✓" : ""}`);
      enable(forward, may);
      enable(reverse, may);
      enable(stop, ctx.mayControl());
    },
  };
}
