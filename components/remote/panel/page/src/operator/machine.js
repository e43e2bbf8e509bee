// Power, e-stop and homing.

import { card, el, enable, setText } from "../dom.js";
import { holdButton } from "../hold.js";
import { STATE } from "./states.js";

/** Makes the card of power and homing. */
export function machineCard(ctx) {
  const { info, store, t, run, signal } = ctx;
  const state = el("p", { class: "state", role: "status", id: "machine-state" });
  const reset = holdButton(t("estop.reset"), t("hold.hint"), () => run("estop-reset"), { id: "estop-reset" });
  const on = holdButton(t("power.on"), t("hold.hint"), () => run("on"), { id: "power-on", class: "primary" });
  const off = el("button", { type: "button", id: "power-off", onclick: () => run("off") }, t("power.off"));
  const home = holdButton(t("home.all"), t("hold.hint"), () => homeJoint("all"), { id: "home-all" });
  const joints = Array.from({ length: info.joints }, (_, j) =>
    holdButton(`J${j}`, t("home.one", j), () => homeJoint(j), { "aria-label": `J${j}: ${t("home.one", j)}` }),
  );
  const unhome = holdButton(t("unhome"), t("hold.hint"), () => run("unhome", { joint: "all" }));

  async function homeJoint(joint) {
    if (await ctx.manual()) await run("home", { joint });
  }

  store.listen(() => {
    const [motion, task, panel] = [store.get("motion"), store.get("task"), store.get("panel")];
    const isEstop = task.state === STATE.estop;
    const isOn = task.state === STATE.on;
    const homed = motion.all_homed ? t("homed") : motion.homing ? t("homing") : t("unhomed");
    const name = isEstop ? "estop" : isOn ? "on" : "off";
    setText(state, task.state === undefined ? t("state.none") : isOn ? `${t("state.on")} · ${homed}` : t(`state.${name}`));
    state.dataset.state = name;
    const may = ctx.mayControl();
    enable(reset, may && isEstop && info.remote?.estop_reset !== false);
    reset.title = info.remote?.estop_reset === false ? t("estop.local") : t("hold.hint");
    enable(on, may && task.state === STATE.off);
    enable(off, isOn && panel.engine === "joined");
    for (const button of [home, unhome, ...joints]) enable(button, may && isOn && !task.interpreter);
    joints.forEach((button, j) => button.classList.toggle("done", motion.joint_homed?.[j] === true));
  }, signal);
  return card(
    "machine", t("machine"), state,
    el("div", { class: "row" }, reset, on, off),
    el("div", { class: "row", role: "group", "aria-label": t("homing") }, home, ...joints, unhome),
  );
}
