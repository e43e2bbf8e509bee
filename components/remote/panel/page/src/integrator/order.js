// The order of functions, what it delays, and how long values take through the machine.

import { el } from "../dom.js";
import { time } from "../format.js";
import { getJson } from "../http.js";
import { asked } from "./diagnose.js";

/** Makes the card of the order of functions. */
export function orderCard(ctx) {
  const { t, signal } = ctx;
  return asked(ctx, "order", t("order"), async () => {
    const order = await getJson("/order", { signal });
    const parts = order.threads.map((thread) => threadPart(thread, t));
    parts.push(waysPart(t("order.paths"), order.paths.map((path) => ({
      name: `${path.from} → ${path.to}`, ways: [path.quickest, path.slowest].filter(Boolean),
    })), order.more_paths, t));
    parts.push(waysPart(t("order.loops"), order.loops.map(({ way }) => ({ name: way.hops[0]?.from ?? "", ways: [way] })), order.more_loops, t));
    return parts.filter(Boolean);
  }).box;
}

/** Shows a thread: its functions, the values that are read late, and the better order if there is one. */
function threadPart(thread, t) {
  const functs = thread.functs.map(({ name, at }) => el("li", {}, el("span", { class: "code" }, name), place(at)));
  const late = thread.late.map(({ hop, remains }) => el("li", { "data-level": remains ? "note" : "warning" },
    el("span", { class: "code" }, `${hop.from} → ${hop.to}`), ` ${via(hop, t)}`, remains ? el("p", { class: "note" }, t("order.remains")) : null));
  const isBest = thread.better.every((name, i) => name === thread.functs[i]?.name);
  return el("details", { open: true }, el("summary", { class: "code" }, `${thread.name}, ${time(thread.period)}`),
    el("ol", {}, ...functs),
    late.length === 0 ? el("p", { class: "note" }, t("order.none")) : el("div", {}, el("b", {}, t("order.late")), el("ul", { class: "findings" }, ...late)),
    isBest ? null : el("div", {}, el("b", {}, t("order.better")), el("ol", {}, ...thread.better.map((name) => el("li", { class: "code" }, name)))));
}

/** Shows ways through functions, with the time that a value takes. */
function waysPart(title, all, areMore, t) {
  if (all.length === 0) return null;
  const ways = all.flatMap(({ name, ways }) => ways.map((way) =>
    el("details", {}, el("summary", {}, el("span", { class: "code" }, name), ` ${delay(way.delay)}`),
      el("ol", {}, ...way.hops.map((hop) => el("li", {}, el("span", { class: "code" }, `${hop.from} → ${hop.to}`), ` ${via(hop, t)}, ${delay(hop.delay)}`))))));
  return el("div", {}, el("h3", {}, title), ...ways, areMore ? el("p", { class: "note" }, t("order.more")) : null);
}

/** Names the signals and pins by which a value passes. */
function via({ by }, t) {
  return by.length === 0 ? t("order.state") : by.join(", ");
}

function delay({ least, most }) {
  return least === most ? time(least) : `${time(least)} – ${time(most)}`;
}

function place(at) {
  return at?.file ? el("span", { class: "note" }, ` ${at.file}:${at.line}`) : null;
}
