// Power, e-stop and homing.

import { card, el, enable, setText, show } from "../dom.js";
import { holdButton } from "../hold.js";

/** Makes the card of power and homing. */
export function machineCard(ctx) {
  const { info, store, t, run, signal } = ctx;
  const state = el("p", { class: "state", role: "status", id: "machine-state" });
  const reset = holdButton(t("estop.reset"), t("hold.hint"), () => run("estop-reset"), { id: "estop-reset" });
  const on = holdButton(t("power.on"), t("hold.hint"), () => run("on"), { id: "power-on", class: "primary" });
  const off = el("button", { type: "button", id: "power-off", onclick: () => ctx.stop("off") }, t("power.off"));
  const home = holdButton(t("home.all"), t("hold.hint"), () => homeJoint("all"), { id: "home-all" });
  const joints = Array.from({ length: info.joints }, (_, j) =>
    holdButton(`J${j}`, t("home.one", j), () => homeJoint(j), { "aria-label": `J${j}: ${t("home.one", j)}` }),
  );
  const unhome = holdButton(t("unhome"), t("hold.hint"), () => run("unhome", { joint: "all" }));

  const bare = el("p", { class: "note", id: "no-task", hidden: true }, t("needs.task"));

  async function homeJoint(joint) {
    if (await ctx.manual()) await run("home", { joint });
  }

  store.listen(() => {
    const [motion, panel, name] = [store.get("motion"), store.get("panel"), ctx.power()];
    const isOn = name === "on";
    const homed = motion.all_homed ? t("homed") : motion.homing ? t("homing") : t("unhomed");
    setText(state, isOn ? `${t("state.on")} · ${homed}` : t(`state.${name}`));
    state.dataset.state = name;
    const may = ctx.mayControl();
    enable(reset, may && name === "estop" && info.remote?.estop_reset !== false);
    show(reset, panel.can_reset !== false);
    reset.title = info.remote?.estop_reset === false ? t("estop.local") : t("hold.hint");
    enable(on, may && name === "off");
    enable(off, isOn && panel.engine === "joined" && ctx.role() !== "viewer");
    for (const button of [home, unhome, ...joints]) enable(button, may && isOn && !ctx.progress());
    show(bare, !ctx.hasTask());
    joints.forEach((button, j) => button.classList.toggle("done", motion.joint_homed?.[j] === true));
  }, signal);
  return card(
    "machine", t("machine"), state, bare,
    el("div", { class: "row" }, reset, on, off),
    el("div", { class: "row", role: "group", "aria-label": t("homing") }, home, ...joints, unhome),
  );
}
