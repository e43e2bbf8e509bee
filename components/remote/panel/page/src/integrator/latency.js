// How late threads wake, with the verdict of latency-test.

import { el } from "../dom.js";
import { getJson } from "../http.js";
import { asked } from "./diagnose.js";

/** Time between two looks while the card is open. */
const LOOK_MS = 2000;
/** Levels of the verdicts, for their colours. */
const LEVELS = { "still-good": "warning", doubtful: "warning", "not-suitable": "error" };

/** Makes the card: the latest wake-up of each thread since it began, and what that means for steps made by software. */
export function latencyCard(ctx) {
  const { t, signal } = ctx;
  const us = (ns) => `${(Number(ns) / 1000).toFixed(1)} µs`;
  const head = ["tree.threads", "threads.late", "latency.verdict"];
  const row = ({ thread, late, verdict }) =>
    el("tr", { "data-thread": thread }, el("th", { scope: "row", class: "code" }, thread), el("td", { class: "number" }, us(late)),
      el("td", { "data-level": LEVELS[verdict] ?? "info", "data-verdict": verdict }, el("b", {}, t(`latency.${verdict}`))));
  const { box, refresh } = asked(ctx, "latency", t("latency"), async () => {
    const threads = await getJson("/latency", { signal });
    return [
      el("table", { class: "grid", "aria-label": t("latency") },
        el("thead", {}, el("tr", {}, ...head.map((key) => el("th", { scope: "col" }, t(key))))), el("tbody", {}, ...threads.map(row))),
      el("p", { class: "note" }, t("latency.note")),
    ];
  });
  // While it is in view it keeps up with the machine.
  let timer = 0;
  const seen = new IntersectionObserver(([entry]) => {
    clearInterval(timer);
    if (entry.isIntersecting) timer = setInterval(refresh, LOOK_MS);
  });
  seen.observe(box);
  signal.addEventListener("abort", () => {
    clearInterval(timer);
    seen.disconnect();
  });
  return box;
}
