// The scope: samples of the engine with a trigger, cursors, measurements and export.

import { card, el, enable, field, setText } from "../dom.js";
import { getJson } from "../http.js";
import { measure, nearest } from "./measure.js";
import { Plot } from "./plot.js";

const MAX_TRACES = 16;
/** Most samples that a stream without a trigger keeps. */
const MAX_SAMPLES = 200_000;
const MEASURES = ["min", "max", "mean", "rms", "frequency", "duty"];

/** Makes the card of the scope. */
export function scopeCard(ctx) {
  const { link, store, t, prefs, session, signal } = ctx;
  const names = text("scope-names", prefs.get("traces").join(" "));
  const seconds = number("scope-seconds", 0.5);
  const every = number("scope-every", 1);
  const thread = el("select", { id: "scope-thread" }, el("option", { value: "" }, t("scope.thread.first")));
  const condition = text("scope-trigger", prefs.get("trigger"));
  condition.placeholder = t("scope.condition.hint");
  const before = number("scope-before", 0.1);
  const auto = el("input", { type: "checkbox", id: "scope-auto" });
  const once = el("input", { type: "checkbox", id: "scope-once" });
  const start = el("button", { type: "button", class: "primary", id: "scope-start", onclick: begin }, t("scope.start"));
  const stop = el("button", { type: "button", id: "scope-stop", onclick: () => end(true) }, t("scope.stop"));
  const save = el("button", { type: "button", id: "scope-export", disabled: true, onclick: exportCsv }, t("scope.export"));
  const state = el("p", { class: "note", role: "status", id: "scope-state" });
  const host = el("div", { class: "plot", tabIndex: 0, role: "group", "aria-label": `${t("scope.plot")}. ${t("scope.keys")}` });
  const table = el("table", { class: "grid", "aria-label": t("scope.measures") });
  const plot = new Plot(host, t, measures);
  let running = null;
  let data = null;

  ctx.addTrace = (name) => {
    const all = traces();
    if (!all.includes(name) && all.length < MAX_TRACES) names.value = [...all, name].join(" ");
    prefs.set("traces", traces());
  };
  const traces = () => names.value.split(/[\s,]+/).filter(Boolean).slice(0, MAX_TRACES);

  async function begin() {
    end(false);
    const when = condition.value.trim();
    prefs.set("traces", traces());
    prefs.set("trigger", when);
    const capture = { names: traces(), every: Number(every.value), seconds: Number(seconds.value) };
    if (thread.value !== "") capture.thread = thread.value;
    if (when !== "") capture.trigger = { when, before: Number(before.value), auto: auto.checked };
    const mine = { hasTrigger: when !== "", captures: 0, lost: 0 };
    running = mine;
    draw();
    try {
      const { names: channels, period } = await link.capture(capture, (message) => running === mine && receive(message));
      if (running !== mine) return;
      mine.period = period;
      data = null;
      save.disabled = true;
      host.dataset.captures = "0";
      plot.open(channels);
      measures();
      setText(state, t(mine.hasTrigger ? "scope.armed" : "scope.running"));
    } catch (error) {
      if (running !== mine) return;
      running = null;
      setText(state, error.message);
      draw();
    }
  }
  function end(isAsked) {
    if (running) link.endCapture();
    if (running && isAsked) setText(state, t("scope.ended"));
    running = null;
    draw();
  }
  function draw() {
    enable(start, ctx.isJoined() && ctx.role() !== "viewer" && !running);
    enable(stop, running !== null);
  }

  function receive(message) {
    if (message.ended !== undefined) {
      setText(state, `${t("scope.ended")}: ${message.ended}`);
      running = null;
      draw();
      return;
    }
    const { columns, times, start: from, trigger, lost } = message;
    running.captures += 1;
    running.lost += lost;
    const origin = trigger === null ? -from : trigger;
    const part = [times.map((time) => time - origin), ...columns];
    data = !running.hasTrigger && data ? data.map((old, i) => [...old, ...part[i]].slice(-keep())) : part;
    plot.show(data);
    host.dataset.captures = String(running.captures);
    setText(state, `${t(running.hasTrigger ? "scope.captured" : "scope.running")} ${running.captures}${running.lost ? ` · ${t("scope.lost")} ${running.lost}` : ""}`);
    save.disabled = false;
    measures();
    if (running.hasTrigger && once.checked) end(false);
  }
  const keep = () => Math.min(MAX_SAMPLES, Math.max(2, Math.ceil(Number(seconds.value) / running.period)));

  function measures() {
    const [a, b] = plot.cursors;
    const isBetween = a !== null && b !== null;
    const [from, to] = isBetween ? [Math.min(a, b), Math.max(a, b)] : [-Infinity, Infinity];
    const digits = (v) => (Number.isFinite(v) ? Number(v.toPrecision(6)).toString() : "—");
    const head = [t("watch.name"), ...MEASURES.map((k) => t(`measure.${k}`)), "A", "B"];
    const at = (column, x) => (x === null ? NaN : column[nearest(data[0], x)]);
    table.replaceChildren(
      el("caption", {}, isBetween ? `${t("scope.between")} ${digits(to - from)} s (${digits(1 / (to - from))} Hz)` : t("scope.cursors")),
      el("thead", {}, el("tr", {}, ...head.map((h) => el("th", { scope: "col" }, h)))),
      el("tbody", {}, ...(data ? plot.names : []).map((name, i) => {
        const values = data[i + 1];
        const m = measure(data[0], values, from, to);
        const cells = [...MEASURES.map((k) => m[k]), at(values, a), at(values, b)];
        return el("tr", { "data-name": name }, el("th", { scope: "row", class: "code" }, name), ...cells.map((v) => el("td", { class: "number" }, digits(v))));
      })),
    );
  }

  function exportCsv() {
    const head = ["time", ...plot.names].join(",");
    const lines = data[0].map((_, i) => data.map((column) => column[i] ?? "").join(","));
    const file = URL.createObjectURL(new Blob([[head, ...lines].join("\n"), "\n"], { type: "text/csv" }));
    el("a", { href: file, download: "scope.csv" }).click();
    setTimeout(() => URL.revokeObjectURL(file), 1000);
  }

  getJson("/threads", { signal }).then((all) => {
    thread.append(...all.map((x) => el("option", { value: x.name }, x.name)));
  }).catch((error) => error.name !== "AbortError" && ctx.fail(error));
  store.listen(() => {
    // A lost connection ends the scope on the server.
    if (running && store.get("link").isOpen === false) end(true);
    draw();
  }, signal);
  signal.addEventListener("abort", () => {
    end(false);
    plot.close();
  });
  return card(
    "scope", t("scope"), field(t("scope.names"), names),
    el("div", { class: "row" }, field(t("scope.thread"), thread), field(t("scope.seconds"), seconds, "s"), field(t("scope.every"), every)),
    el("fieldset", {}, el("legend", {}, t("scope.trigger")), field(t("scope.condition"), condition),
      el("div", { class: "row" }, field(t("scope.before"), before, "s"), field(t("scope.auto"), auto), field(t("scope.once"), once))),
    el("div", { class: "row" }, start, stop, save), state, host,
    el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": t("scope.measures") }, table),
  );
}

function text(id, value) {
  return el("input", { id, autocomplete: "off", spellcheck: false, value });
}

function number(id, value) {
  return el("input", { type: "number", id, value: String(value), min: "0", step: "any" });
}
