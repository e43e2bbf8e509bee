// The scope: samples of the engine with a trigger, cursors, measurements and export.

import uPlot from "../../vendor/uPlot.js";
import { card, el, field, setText } from "../dom.js";
import { getJson } from "../http.js";
import { measure } from "./measure.js";

const COLOURS = ["#3fb1ff", "#ffb020", "#7ed957", "#ff6b8b", "#c78bff", "#4fd6c8", "#f58fd0", "#d9d957"];
const MAX_TRACES = 16;
/** Most samples that a stream without a trigger keeps. */
const MAX_SAMPLES = 200_000;
const HEIGHT_PX = 320;

/** Makes the card of the scope. */
export function scopeCard(ctx) {
  const { link, t, prefs, signal } = ctx;
  const names = el("input", { id: "scope-names", autocomplete: "off", spellcheck: false, value: (prefs.get("traces") ?? []).join(" "), "aria-label": t("scope.names") });
  const seconds = number("scope-seconds", 0.5);
  const every = number("scope-every", 1);
  const thread = el("select", { id: "scope-thread" }, el("option", { value: "" }, t("scope.thread.first")));
  const triggerName = el("input", { id: "scope-trigger", autocomplete: "off", spellcheck: false, placeholder: t("scope.free") });
  const edge = el("select", { id: "scope-edge" }, ...["rise", "fall", "change"].map((e) => el("option", { value: e }, t(`scope.${e}`))));
  const level = number("scope-level", 0.5, "any");
  const before = number("scope-before", 0.1);
  const auto = el("input", { type: "checkbox", id: "scope-auto" });
  const once = el("input", { type: "checkbox", id: "scope-once" });
  const start = el("button", { type: "button", class: "primary", id: "scope-start", onclick: begin }, t("scope.start"));
  const stop = el("button", { type: "button", id: "scope-stop", disabled: true, onclick: end }, t("scope.stop"));
  const save = el("button", { type: "button", id: "scope-export", disabled: true, onclick: () => exportCsv() }, t("scope.export"));
  const state = el("p", { class: "note", role: "status", id: "scope-state" });
  const plotHost = el("div", { class: "plot" });
  const table = el("table", { class: "grid", "aria-label": t("scope.measures") });
  const cursors = [null, null];
  let running = null;
  let data = null;
  let plot = null;
  let captures = 0;

  ctx.addTrace = (name) => {
    const all = traces();
    if (!all.includes(name) && all.length < MAX_TRACES) names.value = [...all, name].join(" ");
    prefs.set("traces", traces());
  };
  const traces = () => names.value.split(/[\s,]+/).filter(Boolean).slice(0, MAX_TRACES);

  async function begin() {
    end();
    prefs.set("traces", traces());
    const options = { names: traces(), every: Number(every.value), seconds: Number(seconds.value) };
    if (thread.value !== "") options.thread = thread.value;
    if (triggerName.value.trim() !== "") {
      options.trigger = { name: triggerName.value.trim(), edge: edge.value, level: Number(level.value), before: Number(before.value), auto: auto.checked };
    }
    captures = 0;
    data = null;
    try {
      running = await link.capture(options, receive);
      running.hasTrigger = Boolean(options.trigger);
      start.disabled = true;
      stop.disabled = false;
      makePlot(running.names);
      setText(state, options.trigger ? t("scope.armed") : t("scope.running"));
    } catch (error) {
      setText(state, error.message);
    }
  }
  function end() {
    if (running) link.endCapture(running.id);
    running = null;
    start.disabled = false;
    stop.disabled = true;
  }

  function receive(message) {
    if (!running) return;
    captures += 1;
    const { columns, start: from, period, trigger, lost } = message;
    const count = columns[0]?.length ?? 0;
    const origin = trigger === null || trigger === undefined ? 0 : from + trigger * period;
    const time = Array.from({ length: count }, (_, i) => from + i * period - origin);
    const isStream = !running.hasTrigger;
    data = isStream && data ? data.map((old, i) => [...old, ...(i === 0 ? time : columns[i - 1])].slice(-keep(period))) : [time, ...columns];
    plot?.setData(data);
    host.dataset.captures = String(captures);
    setText(state, `${t(running.hasTrigger ? "scope.captured" : "scope.running")} ${captures}${lost ? ` · ${t("scope.lost")} ${lost}` : ""}`);
    save.disabled = false;
    measures();
    if (running.hasTrigger && once.checked) end();
  }
  const keep = (period) => Math.min(MAX_SAMPLES, Math.max(2, Math.ceil(Number(seconds.value) / period)));

  function makePlot(list) {
    plot?.destroy();
    const css = getComputedStyle(document.body);
    const [text, line] = [css.getPropertyValue("--text"), css.getPropertyValue("--line")];
    const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line } };
    plot = new uPlot({
      width: plotHost.clientWidth || 600, height: HEIGHT_PX, scales: { x: { time: false } },
      axes: [{ ...axis, label: t("scope.time") }, axis],
      series: [{ label: "s" }, ...list.map((label, i) => ({ label, stroke: COLOURS[i % COLOURS.length], width: 1.5, points: { show: false } }))],
      hooks: { draw: [drawCursors], ready: [(u) => u.over.addEventListener("dblclick", () => clearCursors())] },
      cursor: { drag: { x: true, y: false } },
    }, data ?? [[], ...list.map(() => [])], plotHost);
    plot.over.addEventListener("click", (event) => setCursor(event));
  }
  function setCursor(event) {
    // A click sets the first cursor, with Shift the second.
    const x = plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x");
    cursors[event.shiftKey ? 1 : 0] = x;
    plot.redraw();
    measures();
  }
  function clearCursors() {
    cursors.fill(null);
    measures();
  }
  function drawCursors(u) {
    cursors.forEach((x, i) => {
      if (x === null) return;
      const at = Math.round(u.valToPos(x, "x", true));
      u.ctx.save();
      u.ctx.strokeStyle = i === 0 ? "#ffb020" : "#c78bff";
      u.ctx.setLineDash([6, 4]);
      u.ctx.strokeRect(at, u.bbox.top, 0, u.bbox.height);
      u.ctx.restore();
    });
  }

  function measures() {
    if (!data || !running && !plot) return;
    const [a, b] = cursors;
    const isBetween = a !== null && b !== null;
    const [from, to] = isBetween ? [Math.min(a, b), Math.max(a, b)] : [-Infinity, Infinity];
    const keys = ["min", "max", "mean", "rms", "frequency", "duty"];
    const digits = (v) => (Number.isFinite(v) ? Number(v.toPrecision(6)).toString() : "—");
    const head = [t("watch.name"), ...keys.map((k) => t(`measure.${k}`)), "A", "B"];
    const at = (column, x) => (x === null ? NaN : column[nearest(data[0], x)]);
    table.replaceChildren(
      el("caption", {}, isBetween ? `${t("scope.between")} ${digits(to - from)} s (${digits(1 / (to - from))} Hz)` : t("scope.cursors")),
      el("thead", {}, el("tr", {}, ...head.map((h) => el("th", { scope: "col" }, h)))),
      el("tbody", {}, ...plot.series.slice(1).map((series, i) => {
        const m = measure(data[0], data[i + 1], from, to);
        return el("tr", {}, el("th", { scope: "row", class: "code" }, series.label), ...keys.map((k) => el("td", { class: "number" }, digits(m[k]))),
          el("td", { class: "number" }, digits(at(data[i + 1], a))), el("td", { class: "number" }, digits(at(data[i + 1], b))));
      })),
    );
  }

  function exportCsv() {
    const head = ["time", ...plot.series.slice(1).map((s) => s.label)].join(",");
    const lines = data[0].map((_, i) => data.map((column) => column[i]).join(","));
    const file = URL.createObjectURL(new Blob([[head, ...lines].join("\n"), "\n"], { type: "text/csv" }));
    el("a", { href: file, download: "scope.csv" }).click();
    setTimeout(() => URL.revokeObjectURL(file), 1000);
  }

  getJson("/threads", { signal }).then((all) => {
    thread.append(...all.map((x) => el("option", { value: x.name }, x.name)));
  }).catch(() => {});
  const sizes = new ResizeObserver(() => plot?.setSize({ width: plotHost.clientWidth, height: HEIGHT_PX }));
  sizes.observe(plotHost);
  signal.addEventListener("abort", () => {
    end();
    sizes.disconnect();
    plot?.destroy();
  });
  const host = card(
    "scope", t("scope"), field(t("scope.names"), names),
    el("div", { class: "row" }, field(t("scope.thread"), thread), field(t("scope.seconds"), seconds, "s"), field(t("scope.every"), every)),
    el("fieldset", { class: "row" }, el("legend", {}, t("scope.trigger")), field(t("scope.trigger.name"), triggerName), field(t("scope.edge"), edge),
      field(t("scope.level"), level), field(t("scope.before"), before, "s"), field(t("scope.auto"), auto), field(t("scope.once"), once)),
    el("div", { class: "row" }, start, stop, save), state, plotHost,
    el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": t("scope.measures") }, table),
  );
  return host;
}

function number(id, value, step = "any") {
  return el("input", { type: "number", id, value: String(value), min: "0", step });
}

function nearest(times, x) {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= x) low = middle;
    else high = middle;
  }
  return Math.abs(times[low] - x) <= Math.abs(times[high] - x) ? low : high;
}
