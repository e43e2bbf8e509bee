// Findings of check, the flight recorder, and times of threads.

import { card, el, setText } from "../dom.js";
import { bytes, time } from "../format.js";
import { getJson, listPath } from "../http.js";

/** Makes a card that asks the server when its button is pressed, and when it is first seen. */
export function asked(ctx, id, title, ask, extra = []) {
  const { t, signal } = ctx;
  const body = el("div", { class: "answer", tabIndex: 0, role: "region", "aria-label": title });
  const state = el("p", { class: "note", role: "status" });
  const refresh = async () => {
    try {
      body.replaceChildren(...(await ask()));
      setText(state, "");
    } catch (error) {
      if (error.name !== "AbortError") setText(state, error.message);
    }
  };
  const box = card(id, title, el("div", { class: "row" }, ...extra, el("button", { type: "button", onclick: refresh }, t("refresh"))), state, body);
  const seen = new IntersectionObserver((entries) => {
    if (!entries.some((e) => e.isIntersecting)) return;
    seen.disconnect();
    refresh();
  });
  seen.observe(box);
  signal.addEventListener("abort", () => seen.disconnect());
  return { box, refresh };
}

/** Makes the card of findings. */
export function findingsCard(ctx) {
  const { t, signal } = ctx;
  return asked(ctx, "findings", t("findings"), async () => {
    const all = await getJson("/check", { signal });
    if (all.length === 0) return [el("p", {}, t("findings.none"))];
    return [el("ul", { class: "findings" }, ...all.map((f) =>
      el("li", { "data-level": f.level }, el("b", {}, `${t(`level.${f.level}`)} ${f.code ?? ""}`), " ",
        f.at?.file ? el("span", { class: "code" }, `${f.at.file}:${f.at.line}`) : null, el("p", {}, f.text), f.remedy ? el("p", { class: "note" }, f.remedy) : null)))];
  }).box;
}

/** Shows any answer of the server as nested lists. */
function tree(value) {
  if (value === null || typeof value !== "object") return el("span", { class: "code" }, String(value));
  const entries = Object.entries(value);
  if (entries.length === 0) return el("span", {}, "—");
  return el("ul", { class: "nested" }, ...entries.map(([key, inner]) => {
    const label = Array.isArray(value) ? `${Number(key) + 1}.` : key;
    return el("li", {}, el("b", {}, label), " ", tree(inner));
  }));
}

/** Makes the card of the flight recorder: its memory, the time that it covers, and what it has kept. */
export function flightCard(ctx) {
  const { t, signal } = ctx;
  return asked(ctx, "flight", t("flight"), async () => {
    const flight = await getJson("/flight", { signal });
    const rows = [
      ["flight.values", flight.values], ["flight.memory", `${bytes(flight.used)} / ${bytes(flight.bytes)}`],
      ["flight.covers", `${time(flight.to - flight.from)} (${time(flight.from)} – ${time(flight.to)})`], ["flight.lost", flight.lost],
    ];
    const kept = flight.kept.map(({ number, time: at, why, file, state }) => el("li", {}, el("b", {}, `${number}. ${time(at)}`), ` ${why}`,
      el("p", { class: "note" }, typeof state === "string" ? t(`flight.${state}`) : state.failed, file ? ` ${file}` : "")));
    return [
      el("table", { class: "grid", "aria-label": t("flight") }, el("tbody", {}, ...rows.map(([key, value]) =>
        el("tr", {}, el("th", { scope: "row" }, t(key)), el("td", { class: "number" }, String(value)))))),
      kept.length === 0 ? el("p", { class: "note" }, t("flight.none")) : el("ul", { class: "findings" }, ...kept),
    ];
  }).box;
}

/** Makes the card of threads: their times, those of their functions, overruns, and the histogram of wake-ups. */
export function threadsCard(ctx) {
  const { t, signal } = ctx;
  return asked(ctx, "threads", t("threads"), async () => {
    const [threads, longest, status] = await Promise.all([
      getJson("/threads", { signal }), getJson(listPath("params", ["*.tmax"]), { signal }), getJson("/status", { signal }),
    ]);
    const most = new Map(longest.map((p) => [p.name.replace(/\.tmax$/, ""), Object.values(p.value)[0]]));
    return [
      ...threads.map((thread) => threadPart(thread, most, t)),
      el("details", {}, el("summary", {}, t("threads.instance")), tree(status)),
    ];
  }).box;
}

function threadPart(thread, most, t) {
  const rows = [
    ["threads.period", time(thread.period)], ["threads.time", time(thread.time)], ["threads.tmax", time(thread.tmax)],
    ["threads.cycles", thread.cycles], ["threads.overruns", `${thread.overruns}${thread.overrun_by ? ` (${thread.overrun_by})` : ""}`],
    ["threads.missed", thread.missed], ["threads.late", time(thread.latency_max)],
  ];
  const row = (name, value) => el("tr", {}, el("th", { scope: "row" }, name), el("td", { class: "number" }, String(value)));
  const all = thread.latency.reduce((sum, n) => sum + n, 0);
  const wakes = thread.latency.map((n, i) => ({ n, name: i === thread.latency.length - 1 ? `≥ ${2 ** (i - 1)} µs` : `< ${2 ** i} µs` }));
  return el("details", { open: true }, el("summary", { class: "code" }, thread.name),
    el("table", { class: "grid", "aria-label": thread.name }, el("tbody", {}, ...rows.map(([key, value]) => row(t(key), value)))),
    el("table", { class: "grid", "aria-label": t("threads.wakes") }, el("caption", {}, t("threads.wakes")),
      el("tbody", {}, ...wakes.filter((w) => w.n > 0).map((w) =>
        el("tr", {}, el("th", { scope: "row" }, w.name), el("td", {}, el("meter", { min: 0, max: Math.max(1, all), value: w.n, "aria-label": w.name })), el("td", { class: "number" }, String(w.n)))))),
    el("table", { class: "grid", "aria-label": t("tree.functs") }, el("caption", {}, t("threads.functs")),
      el("tbody", {}, ...thread.functs.map((name) => row(name, most.has(name) ? time(most.get(name)) : "—")))));
}
