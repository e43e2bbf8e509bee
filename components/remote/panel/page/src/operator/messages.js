// Messages of the machine and of the page, with their history, and the prompt for a tool change.

import { card, el, enable, setText, show } from "../dom.js";
import { holdButton } from "../hold.js";

const MAX_KEPT = 500;
const SHOWN_MS = 8000;

/** All messages since the page was opened. */
export class Messages {
  constructor() {
    this.all = [];
    this.listeners = new Set();
  }

  add(level, text) {
    this.all.push({ level, text, time: new Date() });
    if (this.all.length > MAX_KEPT) this.all.shift();
    for (const listener of this.listeners) listener(this.all.at(-1));
  }

  listen(listener, signal) {
    this.listeners.add(listener);
    signal.addEventListener("abort", () => this.listeners.delete(listener));
  }
}

/** Returns a function that takes each new state of the task, and adds the machine's messages since the page was opened. */
export function machineMessages(messages, t) {
  let seen = null;
  return ({ messages: count, message, message_level: level }) => {
    if (count === undefined || count === seen) return;
    // The task counts anew when it starts anew.
    const missed = seen === null ? 0 : count - seen - 1;
    const isFirst = seen === null;
    seen = count;
    if (isFirst || count === 0) return;
    if (missed > 0) messages.add("warning", t("messages.missed", missed));
    messages.add(level === 1 ? "error" : "info", message);
  };
}

/** Makes the card of the history. */
export function messagesCard(ctx) {
  const { messages, t, signal } = ctx;
  const list = el("ol", { class: "log", tabIndex: 0, "aria-label": t("messages") });
  const add = (m) => {
    list.prepend(el("li", { "data-level": m.level }, el("time", {}, m.time.toLocaleTimeString()), el("b", {}, t(`level.${m.level}`)), " ", m.text));
    while (list.childElementCount > MAX_KEPT) list.lastChild.remove();
  };
  messages.all.forEach(add);
  messages.listen(add, signal);
  return card("messages", t("messages"), list);
}

/** Makes the place where new messages appear for a while; errors stay until they are closed. */
export function toasts(ctx) {
  const { messages, t, signal } = ctx;
  const place = el("div", { class: "toasts", role: "region", "aria-label": t("messages.new") });
  messages.listen((m) => {
    const close = el("button", { type: "button", class: "small", "aria-label": t("close"), onclick: () => toast.remove() }, "✕");
    const toast = el("div", { class: "toast", "data-level": m.level, role: m.level === "error" ? "alert" : "status" }, el("span", {}, m.text), close);
    place.append(toast);
    while (place.childElementCount > 4) place.firstChild.remove();
    if (m.level !== "error") setTimeout(() => toast.remove(), SHOWN_MS);
  }, signal);
  return place;
}

/** Makes the prompt that a tool change shows: the operator confirms by holding. */
export function toolPrompt(ctx) {
  const { store, t, run, signal } = ctx;
  const text = el("p", { id: "tool-prompt-text" });
  const done = holdButton(t("tool.changed"), t("hold.hint"), () => run("tool-changed"), { id: "tool-changed", class: "primary" });
  const box = el("section", { id: "tool-prompt", class: "prompt", role: "alertdialog", "aria-labelledby": text.id, hidden: true }, text, done);
  store.listen(() => {
    const awaited = store.get("task").tool_awaited ?? -1;
    show(box, awaited >= 0);
    setText(text, awaited > 0 ? t("tool.insert", awaited) : t("tool.remove"));
    enable(done, ctx.mayControl());
  }, signal);
  return box;
}
