// The run of a program: begin, pause, step, stop.

import { card, el, enable, mark, setText, show } from "../dom.js";
import { duration } from "../format.js";
import { holdButton } from "../hold.js";
import { startPart } from "./start.js";
import { MODE_AUTO, INTERPRETER } from "./states.js";

/** Makes the card that runs programs. */
export function runCard(ctx) {
  const { store, t, run, signal } = ctx;
  const start = holdButton(t("run.start"), t("hold.hint"), begin, { id: "run-start", class: "primary" });
  const pause = el("button", { type: "button", id: "run-pause", onclick: () => run("pause") }, t("run.pause"));
  const resume = holdButton(t("run.resume"), t("hold.hint"), () => run("resume"), { id: "run-resume", class: "primary" });
  const step = holdButton(t("run.step"), t("hold.hint"), stepLine, { id: "run-step" });
  const stop = el("button", { type: "button", id: "run-stop", onclick: () => run("abort") }, t("run.stop"));
  const optional = toggle("optional-stop", t("run.optional"), (on) => run("optional-stop", { on }));
  const deleted = toggle("block-delete", t("run.delete"), (on) => run("block-delete", { on }));
  const state = el("p", { role: "status", id: "run-state" });
  const bar = el("progress", { max: 1, value: 0, "aria-label": t("run.progress") });
  const time = el("p", { class: "row spread" });
  const passed = el("span");
  const left = el("span");
  time.append(passed, left);

  async function begin() {
    // The end of the program is told by the state; a refusal is told at once.
    if (await ctx.mode("auto")) run("run");
  }
  async function stepLine() {
    if (await ctx.mode("auto")) run("step");
  }

  store.listen(() => {
    const [task, motion, panel, program] = ["task", "motion", "panel", "program"].map((part) => store.get(part));
    const isIdle = !task.interpreter;
    const isPaused = task.interpreter === INTERPRETER.paused || task.stepping === true;
    const isRunning = !isIdle && task.mode === MODE_AUTO;
    const may = ctx.mayMove() && task.state === 2;
    // The task's program is not that of a file which is only shown.
    const hasProgram = Boolean(task.file) && !program.isShown;
    enable(start, may && isIdle && hasProgram);
    enable(pause, isRunning && !isPaused);
    enable(resume, may && isPaused);
    enable(step, may && hasProgram && (isIdle || isPaused));
    enable(stop, !isIdle || motion.in_position === false);
    show(pause, !isPaused);
    show(resume, isPaused);
    mark(optional, "aria-pressed", task.optional_stop === true);
    mark(deleted, "aria-pressed", task.block_delete === true);
    for (const button of [optional, deleted]) enable(button, ctx.mayControl());
    const held = panel.job_held ? ` · ${t("run.held")}` : "";
    setText(state, `${stateText(task, t)}${held}`);
    const part = progress(task, motion, program);
    bar.value = isRunning ? part : 0;
    setText(passed, `${t("run.time")} ${duration(task.job_time)}`);
    setText(left, isRunning && task.time_left >= 0 ? `${t("run.left")} ${duration(task.time_left)}` : "");
  }, signal);
  return card(
    "run", t("run"), state, el("div", { class: "row" }, start, pause, resume, step, stop), bar, time,
    el("div", { class: "row" }, optional, deleted), startPart(ctx),
  );
}

function toggle(id, label, change) {
  const button = el("button", { type: "button", id, "aria-pressed": "false" }, label);
  button.addEventListener("click", () => change(button.getAttribute("aria-pressed") !== "true"));
  return button;
}

/** Returns what the task does, in words. */
function stateText(task, t) {
  if (task.stepping && task.interpreter) return t("interpreter.step");
  return t(`interpreter.${["idle", "reading", "paused", "waiting"][task.interpreter ?? 0]}`);
}

/** Returns the share of the program that has been executed, by the length of its path where that is known. */
export function progress(task, motion, program) {
  const line = motion.line || task.line || 0;
  if (program.share) return program.share(line);
  return program.lines > 0 ? Math.min(1, line / program.lines) : 0;
}
