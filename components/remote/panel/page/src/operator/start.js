// The start of a program in its middle: the task proposes it, a person sees the state and confirms.

import { el, enable, field, setText, show } from "../dom.js";
import { AXES } from "../format.js";
import { holdButton } from "../hold.js";
import { getJson } from "../http.js";

/** Makes the part of the card of the run. `chosenLoss` tells what becomes of the job when the page is lost. */
export function startPart(ctx, chosenLoss) {
  const { info, link, store, t, run, signal } = ctx;
  const line = el("input", { type: "number", id: "run-from-line", min: "1", step: "1", value: "1" });
  const propose = el("button", { type: "button", id: "run-from", onclick: () => ask("run-from", { line: Number(line.value) }) }, t("run.from.ask"));
  const recover = el("button", { type: "button", id: "run-recover", onclick: () => ask("recover", {}) }, t("run.from.recover"));
  const state = el("p", { class: "note", role: "status", id: "run-from-state" });
  const shown = el("div", { class: "answer", id: "run-from-shown", tabIndex: -1, role: "region", "aria-label": t("run.from") });
  const confirm = holdButton(t("run.from.begin"), t("hold.hint"), begin, { id: "run-from-confirm", class: "primary" });
  const cancel = el("button", { type: "button", id: "run-from-cancel", onclick: forget }, t("cancel"));
  let token = null;

  async function ask(command, args) {
    forget();
    if (!(await ctx.mode("auto"))) return;
    setText(state, t("run.from.wait"));
    try {
      await link.command(command, args);
      const start = await getJson("/start", { signal });
      setText(state, "");
      shown.replaceChildren(...proposal(start));
      if (!start.not_ready) token = start.token;
      show(shown, true);
      draw();
      shown.focus();
    } catch (error) {
      if (error.name !== "AbortError") setText(state, error.message);
    }
  }
  async function begin() {
    if (token === null) return;
    const args = { token, ...chosenLoss() };
    forget();
    await run("confirm", args);
  }
  function forget() {
    token = null;
    setText(state, "");
    shown.replaceChildren();
    draw();
  }

  /** Shows the state before the line, and the steps that lead there. */
  function proposal(start) {
    const unit = ctx.units();
    const at = (place) => [...info.axes.toLowerCase()].map((a) => `${a.toUpperCase()} ${unit.text(place[AXES.indexOf(a)], a)}`).join("  ");
    const rows = [
      ["run.from.codes", `${start.codes} F${start.feed}`], ["tools.number", `T${start.tool}${start.selected === start.tool ? "" : ` → T${start.selected}`}`],
      ["spindle", start.spindles.map((s) => String(s)).join(" ")],
      ["coolant", [start.mist && t("mist"), start.flood && t("flood")].filter(Boolean).join(" ") || "—"], ["run.from.place", at(start.position)],
    ];
    const list = (key, items) => (items.length > 0 ? [el("h3", {}, t(key)), el("ol", {}, ...items.map((x) => el("li", {}, x)))] : []);
    return [
      el("p", {}, el("b", {}, t("run.from.state", start.line, start.file.split("/").at(-1), start.pass, start.passes))),
      el("table", { class: "grid" }, el("tbody", {}, ...rows.map(([key, value]) => el("tr", {}, el("th", { scope: "row" }, t(key)), el("td", {}, value))))),
      ...(start.not_ready ? [el("p", { role: "alert" }, `${t("run.from.not")}: ${start.not_ready}`)] : []),
      ...list("run.from.notes", start.notes),
      ...list("run.from.entry", start.entry.map((step) => `${step.kind}: ${step.text}${step.to ? ` ${at(step.to)}` : ""}`)),
    ];
  }

  let known = null;
  function draw() {
    const [task, program] = [store.get("task"), store.get("program")];
    const may = ctx.hasTask() && ctx.mayMove() && ctx.isOn() && !task.interpreter;
    // Another program, or a line that runs, makes a proposal worthless: the task would refuse it. A program that is shown and
    // is not that of the task must not be taken for the one that begins.
    if (token !== null && (task.file !== known || task.interpreter || program.isShown)) token = null;
    known = task.file;
    if (program.chosen && document.activeElement !== line && program.chosen !== chosen) line.value = String(program.chosen);
    chosen = program.chosen;
    enable(propose, may && Boolean(task.file) && !program.isShown);
    enable(recover, may && !program.isShown);
    enable(confirm, may && token !== null && !program.isShown);
    show(shown, shown.children.length > 0);
    show(confirm, token !== null);
    show(cancel, shown.children.length > 0);
  }
  let chosen = null;
  store.listen(draw, signal);
  return el("details", { id: "run-start-at" }, el("summary", {}, t("run.from")),
    el("div", { class: "row" }, field(t("run.from"), line), propose, recover), state, shown, el("div", { class: "row" }, confirm, cancel));
}
