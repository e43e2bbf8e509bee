// The run of a program: begin, pause, step, stop.

import { card, el, enable, field, mark, setText, show } from "../dom.js";
import { duration } from "../format.js";
import { holdButton } from "../hold.js";
import { canResume, wordsOf } from "./held.js";
import { startPart } from "./start.js";
import { INTERPRETER, MODE_AUTO } from "./states.js";

/** What becomes of a job whose page is lost. */
const LOSSES = ["hold", "continue", "abort"];

/** Makes the card that runs programs. */
export function runCard(ctx) {
  const { info, store, t, run, signal } = ctx;
  const start = holdButton(t("run.start"), t("hold.hint"), begin, { id: "run-start", class: "primary" });
  const pause = el("button", { type: "button", id: "run-pause", onclick: () => ctx.stop("pause") }, t("run.pause"));
  const resume = holdButton(t("run.resume"), t("hold.hint"), () => run("resume", chosenLoss()), { id: "run-resume", class: "primary" });
  const step = holdButton(t("run.step"), t("hold.hint"), stepLine, { id: "run-step" });
  const stop = el("button", { type: "button", id: "run-stop", onclick: () => ctx.stop("abort") }, t("run.stop"));
  const loss = el("select", { id: "on-loss" }, ...LOSSES.map((name) => el("option", { value: name }, t(`loss.${name}`))));
  loss.value = info.on_loss ?? LOSSES[0];
  const lossField = field(t("loss.choose"), loss);
  const confirmed = el("p", { class: "note", role: "status", id: "on-loss-state" });
  const bare = el("p", { class: "note", hidden: true }, t("needs.task"));
  const optional = toggle("optional-stop", t("run.optional"), (on) => run("optional-stop", { on }));
  const deleted = toggle("block-delete", t("run.delete"), (on) => run("block-delete", { on }));
  const shown = el("p", { role: "status", id: "run-state" });
  const bar = el("progress", { max: 1, value: 0, "aria-label": t("run.progress") });
  const time = el("p", { class: "row spread" });
  const passed = el("span");
  const left = el("span");
  time.append(passed, left);

  async function begin() {
    // The end of the program is told by the state; a refusal is told at once.
    if (await ctx.mode("auto")) run("run", chosenLoss());
  }
  /** Returns what the start says of a lost page, as the card shows it. */
  function chosenLoss() {
    return ctx.hasTask() ? { on_loss: loss.value } : {};
  }
  async function stepLine() {
    if (!ctx.hasTask() || (await ctx.mode("auto"))) run("step");
  }

  let isNew = true;
  store.listen(() => {
    const [task, motion, panel, program] = ["task", "motion", "panel", "program"].map((part) => store.get(part));
    const state = ctx.progress();
    const isIdle = !state;
    const isPaused = state === INTERPRETER.paused || task.stepping === true;
    const isRunning = !isIdle && (task.mode === MODE_AUTO || !ctx.hasTask());
    const may = ctx.mayMove() && ctx.isOn();
    const resumes = canResume(panel);
    // The task's program is not that of a file which is only shown.
    const hasProgram = Boolean(task.file) && !program.isShown;
    enable(start, may && isIdle && hasProgram && ctx.hasTask());
    enable(pause, isRunning && !isPaused && ctx.role() !== "viewer");
    // Wherever something is held that a person ends, also without a pause.
    enable(resume, may && resumes);
    enable(step, may && (isPaused || (isIdle && hasProgram && ctx.hasTask())));
    enable(stop, !isIdle || motion.in_position === false);
    show(pause, !isPaused);
    show(resume, resumes || isPaused);
    show(bare, !ctx.hasTask());
    for (const node of [start, lossField, optional, deleted]) show(node, ctx.hasTask());
    mark(optional, "aria-pressed", task.optional_stop === true);
    mark(deleted, "aria-pressed", task.block_delete === true);
    for (const button of [optional, deleted]) enable(button, ctx.mayControl());
    // It is chosen before the start, and may be changed where the job rests.
    enable(loss, may && (isIdle || resumes));
    // A page that is opened later shows what the job's start said.
    if (!isIdle && isNew && panel.on_loss) loss.value = panel.on_loss;
    isNew = isIdle;
    setText(confirmed, isIdle || !panel.on_loss || !ctx.hasTask() ? "" : `${t("loss.of.job")}: ${t(`loss.${panel.on_loss}`)}`);
    const held = (panel.holds ?? []).map((hold) => wordsOf(hold, t));
    setText(shown, [stateText(task, state, t), ...held].join(" · "));
    const part = progress(task, motion, program);
    bar.value = isRunning ? part : 0;
    setText(passed, `${t("run.time")} ${duration(task.job_time)}`);
    setText(left, isRunning && task.time_left >= 0 ? `${t("run.left")} ${duration(task.time_left)}` : "");
  }, signal);
  return card(
    "run", t("run"), bare, shown, lossField, confirmed, el("div", { class: "row" }, start, pause, resume, step, stop), bar, time,
    el("div", { class: "row" }, optional, deleted), startPart(ctx, chosenLoss),
  );
}

function toggle(id, label, change) {
  const button = el("button", { type: "button", id, "aria-pressed": "false" }, label);
  button.addEventListener("click", () => change(button.getAttribute("aria-pressed") !== "true"));
  return button;
}

/** Returns what the task does, or the path of a machine without one, in words. */
function stateText(task, state, t) {
  if (task.stepping && state) return t("interpreter.step");
  return t(`interpreter.${["idle", "reading", "paused", "waiting"][state]}`);
}

/** Returns the share of the program that has been executed, by the length of its path where that is known. */
export function progress(task, motion, program) {
  const line = motion.line || task.line || 0;
  if (program.share) return program.share(line);
  return program.lines > 0 ? Math.min(1, line / program.lines) : 0;
}
