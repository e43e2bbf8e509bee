// The marks of the job: where they are expected, where they were found, and the place of the part that they give.

import { card, el, enable, field, setText, show } from "../dom.js";
import { holdButton } from "../hold.js";
import { getJson, programPath, request } from "../http.js";

/** Time between two looks, in ms. */
const LOOK_MS = 500;

/** Makes the card. */
export function marksCard(ctx) {
  const { store, t, run, signal } = ctx;
  const body = el("tbody");
  const head = ["marks.number", "marks.do", "marks.found", "marks.uncertainty", "marks.residual"];
  const table = el("table", { class: "grid", id: "marks-table", "aria-label": t("marks") },
    el("thead", {}, el("tr", {}, ...head.map((key) => el("th", { scope: "col" }, t(key))))), body);
  const problem = el("p", { class: "note", role: "status", id: "marks-problem" });
  const fit = el("table", { class: "grid", id: "marks-fit", "aria-label": t("fit") });
  const warnings = el("ul", { class: "findings", id: "marks-warnings" });
  const solve = el("button", { type: "button", id: "marks-solve", onclick: () => run("align-solve") }, t("fit.solve"));
  const clear = el("button", { type: "button", id: "marks-clear", onclick: () => run("align-clear") }, t("marks.clear"));
  const arcs = el("select", { id: "rewrite-arcs" }, ...["lines", "refuse"].map((how) => el("option", { value: how }, t(`rewrite.${how}`))));
  const rewrite = el("button", { type: "button", id: "rewrite", onclick: rewriteProgram }, t("rewrite"));
  const rewritten = el("p", { class: "note", role: "status", id: "rewritten" });
  const sight = el("button", { type: "button", id: "calibrate-sight", onclick: () => run("align-sight") }, t("calibrate.sight"));
  const calibrate = el("button", { type: "button", id: "calibrate", onclick: () => run("align-calibrate") }, t("calibrate"));
  const sights = el("span", { class: "note" });
  let rows = [];

  async function go([x, y]) {
    if (await ctx.mode("mdi")) await run("align-go", { x, y });
  }

  async function rewriteProgram() {
    const { name } = store.get("program");
    setText(rewritten, "");
    try {
      const done = await (await request("POST", programPath(name, "/align"), { json: { arcs: arcs.value } })).json();
      setText(rewritten, t("rewrite.done", done.name, done.changed, done.arcs) + (done.feed_is_uneven ? ` ${t("rewrite.feed")}` : ""));
      if (ctx.hasLease()) await run("open", { program: done.name });
    } catch (error) {
      if (error.name !== "AbortError") setText(rewritten, error.message);
    }
  }

  /** Makes the rows again where the job has another number of marks. */
  function makeRows(count) {
    rows = Array.from({ length: count }, (_, i) => {
      const cells = head.slice(2).map(() => el("td", { class: "number" }));
      const to = holdButton(t("marks.go"), t("hold.hint"), () => go(store.get("align").marks[i].aim), { class: "small", "aria-label": t("marks.go.to", i + 1) });
      const look = el("button", { type: "button", class: "small", "aria-label": t("marks.look.at", i + 1), onclick: () => run("align-look", { mark: i + 1 }) }, t("marks.look"));
      const place = el("span", { class: "note" });
      const title = el("th", { scope: "row" }, `${i + 1} `, place);
      return { cells, to, look, place, row: el("tr", { "data-mark": String(i + 1) }, title, el("td", {}, el("div", { class: "row" }, to, look)), ...cells) };
    });
    body.replaceChildren(...rows.map(({ row }) => row));
  }

  store.listen(() => {
    const [align, task, program] = [store.get("align"), store.get("task"), store.get("program")];
    const marks = align.marks ?? [];
    if (marks.length !== rows.length) makeRows(marks.length);
    const may = ctx.hasTask() && ctx.mayMove() && ctx.isOn() && (task.mode === 2 || !task.interpreter);
    marks.forEach((mark, i) => {
      const { cells, to, look, place } = rows[i];
      const um = (list) => list?.map((mm) => 1000 * mm) ?? null;
      const texts = [pair(mark.machine, 4), mark.uncertainty === null ? "—" : (1000 * mark.uncertainty).toFixed(1), pair(um(mark.residual), 1)];
      setText(place, mark.file.map(Number).join(", "));
      cells.forEach((cell, k) => setText(cell, texts[k]));
      enable(to, may && Boolean(mark.aim));
      enable(look, ctx.mayControl());
    });
    setText(problem, align.problem ?? "");
    drawFit(align);
    for (const button of [solve, clear]) enable(button, ctx.mayControl());
    for (const button of [sight, calibrate]) enable(button, ctx.mayControl() && ctx.role() === "integrator");
    enable(rewrite, ctx.role() !== "viewer" && Boolean(align.fit) && Boolean(program.name));
    setText(sights, t("calibrate.sights", align.sights ?? 0));
  }, signal);

  function drawFit({ fit: found, live, tolerance }) {
    const list = !found ? [] : [
      ["fit.model", found.model], ["fit.turn", `${found.theta.toFixed(4)}°`], ["fit.scales", `${found.sx.toFixed(6)}  ${found.sy.toFixed(6)}`],
      ["fit.shear", `${found.shear.toFixed(4)}°`], ["fit.shift", pair([found.tx, found.ty], 4)],
      ["fit.rms", `${found.rms.toFixed(4)} / ${tolerance}`], ["fit.live", live ? t("fit.live.yes") : t("fit.live.no")],
    ];
    const key = JSON.stringify(list);
    if (fit.dataset.key !== key) {
      fit.dataset.key = key;
      fit.replaceChildren(el("tbody", {}, ...list.map(([name, value]) => el("tr", {}, el("th", { scope: "row" }, t(name)), el("td", { class: "number" }, value)))));
      warnings.replaceChildren(...(found?.warnings ?? []).map((text) => el("li", { "data-level": "warning" }, el("b", {}, t("level.warning")), ` ${text}`)));
    }
    show(fit, list.length > 0);
  }

  async function refresh() {
    if (document.hidden) return;
    try {
      store.replace("align", await getJson("/align", { signal }));
    } catch (error) {
      if (error.name !== "AbortError") setText(problem, error.message);
    }
  }
  const timer = setInterval(refresh, LOOK_MS);
  signal.addEventListener("abort", () => clearInterval(timer));
  refresh();
  return card("marks", t("marks"), el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": t("marks") }, table),
    el("div", { class: "row" }, solve, clear), problem, fit, warnings,
    el("div", { class: "row" }, field(t("rewrite.arcs"), arcs), rewrite), rewritten,
    el("details", {}, el("summary", {}, t("calibrate.title")), el("p", { class: "note" }, t("calibrate.hint")), el("div", { class: "row" }, sight, calibrate, sights)));
}

/** Returns X and Y as a text. */
function pair(xy, digits) {
  return xy ? xy.map((n) => n.toFixed(digits)).join("  ") : "—";
}
