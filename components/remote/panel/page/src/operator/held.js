// What is held, wherever: its reason in words, and the entry in the log.

/** Kinds of holds that the page has words for. Others are told in the words of the machine. */
export const KINDS = [
  "adaptive", "at-speed", "feed-hold", "feed-zero", "function", "index", "inhibit", "input", "lease", "optional-stop", "orient", "override", "pallet",
  "paused", "program", "rapid-zero", "spindle-speed", "spindle-stopped", "step", "stop", "tool", "user-program",
];

/** Returns a hold in words: who is waited for, and how to go on. */
export function wordsOf(hold, t) {
  if (KINDS.includes(hold.kind)) return t(`held.${hold.kind}`, hold.by || hold.number);
  return hold.text || hold.kind;
}

/** Returns the holds that last until somebody ends them. The prompt for a tool asks for itself. */
export const lasting = (panel) => (panel.holds ?? []).filter((hold) => !hold.ends && hold.kind !== "tool");

/** Returns whether `resume` ends one of them. */
export const canResume = (panel) => (panel.holds ?? []).some((hold) => hold.resumes);

/** Returns a function that takes each new state of the panel, and adds an entry to the log when a hold begins, and when all have ended. */
export function holdMessages(messages, t) {
  let known = null;
  return (panel) => {
    if (panel.holds === undefined) return;
    const now = new Map(lasting(panel).map((hold) => [`${hold.kind} ${hold.by}`, hold]));
    if (known) {
      for (const [key, hold] of now) if (!known.has(key)) messages.add("warning", `${t("held")}: ${wordsOf(hold, t)}`);
      if (known.size > 0 && now.size === 0) messages.add("info", t("held.ended"));
    }
    known = now;
  };
}
