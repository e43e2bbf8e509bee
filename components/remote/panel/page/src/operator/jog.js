// Jogs: by holding a button, in steps, by keys and by a wheel.

import { card, el, enable, field, mark, setText, show } from "../dom.js";
import { isAngular, length } from "../format.js";
import { JOG_HOLD_MS, isHeld, noteJog, watchHold } from "../hold.js";

/** Time in ms without beats after a refused stop: the machine has ended the jog by then. */
const SILENCE_MS = 200;
/** Number of the axis or joint that a key moves, and its direction. */
const KEYS = {
  ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowDown: [1, -1], ArrowUp: [1, 1], PageDown: [2, -1], PageUp: [2, 1],
  "[": [3, -1], "]": [3, 1],
};

/** Makes the card of jogs. */
export function jogCard(ctx) {
  const { info, store, t, prefs, signal } = ctx;
  const axes = [...info.axes.toLowerCase()].map((axis) => ({ name: axis.toUpperCase(), axis, target: { axis: axis.toUpperCase() } }));
  const joints = Array.from({ length: info.joints }, (_, j) => jointOf(info, j));
  const jogger = new Jogger(ctx);
  const isRead = (text) => length(text, info.linear_units) > 0;
  const increments = ["0", ...(info.increments ?? []).filter(isRead)];
  const unread = (info.increments ?? []).filter((text) => !isRead(text));
  const step = el(
    "select", { id: "jog-step", onchange: () => prefs.set("step", step.value) },
    ...increments.map((text) => el("option", { value: text }, text === "0" ? t("jog.continuous") : text)),
  );
  step.value = increments.includes(prefs.get("step")) ? prefs.get("step") : "0";
  jogger.step = () => step.value;

  const speed = slider(ctx, "jog-speed", info.default_linear_velocity, info.max_linear_velocity, false);
  const hasTurning = [...axes, ...joints].some(({ axis }) => isAngular(axis));
  const turning = hasTurning ? slider(ctx, "jog-turn-speed", info.default_angular_velocity, info.max_angular_velocity, true) : null;
  jogger.speed = (item) => Number((isAngular(item.axis) ? turning : speed).input.value);

  // Before homing only joints move; after it, axes.
  const pads = [joints, axes].map((items, i) => padOf(items, i === 1, jogger, step, t));
  const buttons = pads.flatMap((pad) => [...pad.querySelectorAll("button")]);
  const items = () => (store.get("motion").all_homed ? axes : joints);
  const keys = el("button", { type: "button", id: "jog-keys", "aria-pressed": "false", onclick: () => setKeys(!keysOn) }, t("jog.keys"));
  const banner = el("p", { class: "banner", role: "status", hidden: true }, t("jog.keys.on"));
  const why = el("p", { class: "note" });
  let keysOn = false;

  function setKeys(is) {
    keysOn = is && ctx.mayMove();
    mark(keys, "aria-pressed", keysOn);
    show(banner, keysOn);
    document.body.classList.toggle("keys-jog", keysOn);
    jogger.stopKey();
  }
  watchKeys(jogger, items, { isOn: () => keysOn, end: () => setKeys(false), signal });

  store.listen(() => {
    const may = ctx.mayJog();
    const isHomed = items() === axes;
    show(pads[0], !isHomed);
    show(pads[1], isHomed);
    for (const button of buttons) enable(button, may);
    enable(keys, may);
    if (!may && keysOn) setKeys(false);
    setText(why, may ? "" : ctx.whyNot());
    show(why, !may);
  }, signal);
  signal.addEventListener("abort", () => setKeys(false));
  return card(
    "jog", t("jog"), banner, ...pads, why,
    el("div", { class: "row" }, field(t("jog.step"), step), keys),
    unread.length > 0 ? el("p", { class: "note" }, t("jog.unread", unread.join(", "))) : null,
    speed.label, turning?.label ?? null,
  );
}

function jointOf(info, j) {
  const isTurning = info.limits?.joints?.[j]?.type === "ANGULAR";
  return { name: `J${j}`, axis: isTurning ? "a" : "x", target: { joint: j } };
}

function padOf(items, areAxes, jogger, step, t) {
  const buttons = items.flatMap((item) => [-1, 1].map((way) => jogButton(item, way, jogger, t)));
  const pad = el("div", { class: `pad${areAxes ? " axes" : ""}`, role: "group", "aria-label": t("jog") }, ...buttons);
  // A wheel over the focused button of an axis makes steps, if a step is chosen.
  pad.addEventListener("wheel", (event) => {
    const button = event.target.closest("[data-jog]");
    if (!button || button.disabled || step.value === "0" || document.activeElement !== button) return;
    event.preventDefault();
    jogger.begin(items.find((item) => item.name === button.dataset.jog), event.deltaY < 0 ? 1 : -1);
  }, { passive: false });
  return pad;
}

function jogButton(item, way, jogger, t) {
  const sign = way < 0 ? "−" : "+";
  const side = way < 0 ? "minus" : "plus";
  const button = el(
    "button",
    { type: "button", class: `jog jog-${item.name}-${side}`, "data-jog": item.name, "data-way": way, "aria-label": `${t("jog")} ${item.name}${sign}` },
    `${item.name}${sign}`,
  );
  watchHold(button, { delay: JOG_HOLD_MS, begin: () => jogger.begin(item, way, () => isHeld(button)), end: () => jogger.end(item) });
  return button;
}

function slider(ctx, id, first, most, isTurning) {
  const { t, prefs } = ctx;
  const max = Number.isFinite(most) ? most : Math.max(1, (first ?? 1) * 10);
  const input = el("input", { type: "range", id, min: String(max / 1000), max: String(max), step: "any" });
  input.value = String(Math.min(max, prefs.get(id) ?? first ?? max / 10));
  const output = el("output", { for: id });
  const unit = ctx.units();
  const draw = () => {
    const value = Number(input.value);
    setText(output, isTurning ? `${value.toFixed(1)} °/s` : `${unit.show(value).toFixed(1)} ${unit.unit("x")}/s`);
  };
  input.addEventListener("input", draw);
  input.addEventListener("change", () => prefs.set(id, Number(input.value)));
  draw();
  return { input, label: el("label", { class: "slide" }, el("span", {}, t(isTurning ? "jog.turn" : "jog.speed")), input, output) };
}

/** Keys jog wherever the focus is, while the mode is on, which the page shows; typing, blur and Escape end it. */
export function watchKeys(jogger, items, { isOn, end, signal }) {
  const isTyping = (node) => node instanceof Element && node.matches("input:not([type=range]), textarea, select, dialog, dialog *");
  window.addEventListener("keydown", (event) => {
    if (!isOn()) return;
    if (event.key === "Escape") return end();
    // Another key, such as Shift, may change what the release of the first one is called.
    if (!event.repeat) jogger.stopKey();
    const [index, way] = KEYS[event.key] ?? [];
    const item = items()[index];
    if (!item || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    if (!event.repeat) jogger.beginKey(item, way);
  }, { signal });
  window.addEventListener("keyup", () => jogger.stopKey(), { signal });
  document.addEventListener("focusin", (event) => isOn() && isTyping(event.target) && end(), { signal });
  window.addEventListener("blur", () => isOn() && end(), { signal });
  document.addEventListener("visibilitychange", () => isOn() && document.hidden && end(), { signal });
}

/** Jogs in progress. */
export class Jogger {
  constructor(ctx) {
    this.ctx = ctx;
    this.active = new Map();
    this.key = null;
  }

  /** Begins a jog, which ends when nothing holds it; a step ends by itself. */
  async begin(item, way, isHeld) {
    if (this.active.has(item)) return;
    const text = this.step();
    const velocity = this.speed(item) * way;
    const jog = { isStep: text !== "0" };
    this.active.set(item, jog);
    if (!jog.isStep) jog.ended = noteJog({ isHeld, end: () => this.active.get(item) === jog && this.end(item) });
    const isReady = await this.ctx.manual();
    // A release during the change of mode ends the jog before it begins.
    if (!isReady || this.active.get(item) !== jog) {
      if (this.active.get(item) === jog) {
        this.active.delete(item);
        jog.ended?.();
      }
      return;
    }
    if (!jog.isStep) {
      await this.ctx.run("jog", { ...item.target, velocity });
      return;
    }
    const distance = length(text, isAngular(item.axis) ? "mm" : this.ctx.info.linear_units);
    if (distance !== null) await this.ctx.run("jog", { ...item.target, velocity: Math.abs(velocity), distance: distance * way });
    this.active.delete(item);
  }

  async end(item) {
    const jog = this.active.get(item);
    if (!jog || jog.isStep) return;
    this.active.delete(item);
    if (await this.ctx.run("jog-stop")) jog.ended();
    else setTimeout(jog.ended, SILENCE_MS);
  }

  beginKey(item, way) {
    if (this.key !== null) return;
    const key = { item };
    this.key = key;
    this.begin(item, way, () => this.key === key);
  }

  stopKey() {
    if (this.key === null) return;
    const { item } = this.key;
    this.key = null;
    this.end(item);
  }
}
