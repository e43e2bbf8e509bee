// The banner that says what is held, with Resume.

import { el, enable, setText, show } from "../dom.js";
import { duration } from "../format.js";
import { holdButton } from "../hold.js";
import { canResume, lasting, wordsOf } from "./held.js";

/** Makes the banner. */
export function holdBanner(ctx) {
  const { info, store, t, run, signal } = ctx;
  const text = el("span", { id: "hold-text" });
  const resume = holdButton(t("run.resume"), t("hold.hint"), () => run(info.isRobot ? "robot-resume" : "resume"), { id: "hold-resume", class: "primary" });
  const box = el("div", { class: "banner held", role: "status", hidden: true, id: "hold-banner", "aria-label": t("held") }, text, resume);
  store.listen(() => {
    const [panel, motion] = [store.get("panel"), store.get("motion")];
    const holds = ctx.isJoined() ? lasting(panel) : [];
    show(box, holds.length > 0);
    const since = holds.map((hold) => hold.since).find((n) => Number.isFinite(n) && n > 0);
    const time = since === undefined ? "" : ` (${duration(motion.time_ns * 1e-9 - since)})`;
    setText(text, `${t("held")}: ${holds.map((hold) => wordsOf(hold, t)).join(" ")}${time}`);
    const resumes = canResume(panel);
    show(resume, resumes);
    enable(resume, resumes && ctx.mayMove() && ctx.isOn());
    resume.title = resume.disabled ? ctx.whyNot() : t("hold.hint");
  }, signal);
  return box;
}
