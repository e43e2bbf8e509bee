// Single lines of G-code, with their history, and the buttons of the INI file.

import { card, el, enable, setText, show } from "../dom.js";
import { gCode } from "../format.js";
import { holdButton } from "../hold.js";

const MAX_HISTORY = 100;

/** Makes the card of MDI. */
export function mdiCard(ctx) {
  const { info, store, t, prefs, run, signal } = ctx;
  const input = el("input", {
    id: "mdi-line", type: "text", autocomplete: "off", spellcheck: false, maxLength: 255, "aria-label": t("mdi.line"), placeholder: "G0 X0",
  });
  input.setAttribute("autocapitalize", "characters");
  const history = el("ol", { class: "history", "aria-label": t("mdi.history") });
  const go = holdButton(t("mdi.run"), t("hold.hint"), () => execute(input.value), { id: "mdi-run" });
  const active = el("p", { class: "note code", id: "mdi-active" });
  const bare = el("p", { class: "note", hidden: true }, t("needs.task"));
  let at = -1;

  async function execute(text) {
    const line = text.trim();
    if (line === "") return;
    const lines = [line, ...prefs.get("mdi").filter((old) => old !== line)].slice(0, MAX_HISTORY);
    prefs.set("mdi", lines);
    at = -1;
    if (!(await ctx.mode("mdi"))) return;
    if (await run("mdi", { text: line })) input.value = "";
  }
  const form = el("form", { class: "row", onsubmit: (event) => {
    event.preventDefault();
    if (!go.disabled) execute(input.value);
  } }, input, go);
  input.addEventListener("keydown", (event) => {
    const step = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    const lines = prefs.get("mdi");
    if (!step || lines.length === 0) return;
    event.preventDefault();
    at = Math.max(-1, Math.min(lines.length - 1, at + step));
    input.value = at < 0 ? "" : lines[at];
  });
  const own = (info.mdi_commands ?? []).map((command) =>
    holdButton(command.label ?? command.name, command.lines, () => runOwn(command.lines)),
  );
  async function runOwn(text) {
    if (!(await ctx.mode("mdi"))) return;
    for (const line of text.split(/[;\n]/).map((l) => l.trim()).filter(Boolean)) if (!(await run("mdi", { text: line }))) return;
  }

  prefs.listen(() => {
    history.replaceChildren(
      ...prefs.get("mdi").slice(0, 20).map((line) =>
        el("li", {}, el("button", { type: "button", class: "plain code", onclick: () => { input.value = line; input.focus(); } }, line)),
      ),
    );
  }, signal);
  store.listen(() => {
    const task = store.get("task");
    const may = ctx.hasTask() && ctx.mayMove() && ctx.isOn() && (task.mode === 2 || !task.interpreter);
    show(bare, !ctx.hasTask());
    for (const button of [go, ...own]) enable(button, may);
    setText(active, (task.g_codes ?? []).filter((code) => code > 0).map(gCode).join(" "));
  }, signal);
  return card(
    "mdi", t("mdi"), bare, form, active, history,
    own.length > 0 ? el("div", { class: "row", role: "group", "aria-label": t("mdi.own") }, ...own) : null,
  );
}
