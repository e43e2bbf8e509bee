// What the cards share: commands with their refusals, modes, rights.

import { Units } from "./format.js";
import { MODES, mayJogBeside, powerOf, progressOf } from "./operator/states.js";

/** Adds what all cards need to the parts of the page. */
export function context(ctx) {
  const { info, session, link, store, messages, prefs, t } = ctx;
  const machineUnit = info.linear_units === "inch" ? "inch" : "mm";
  link.lostText = t("link.lost");

  const fail = (error) => {
    if (error.code === "no-server" && !store.get("link").isOpen) messages.add("error", t("link.lost"));
    else messages.add("error", error.message);
  };
  /** Executes a command; a refusal becomes a message. Resolves to whether it succeeded. */
  const run = async (name, args = {}) => {
    try {
      await link.command(name, args);
      return true;
    } catch (error) {
      fail(error);
      return false;
    }
  };
  /** Stops: what was done, or refused, is a message. */
  const stop = async (name) => {
    try {
      const done = await link.command(name, {}, ({ lines }) => lines && messages.add("info", lines.join("; ")));
      if (done.lines) messages.add("info", done.lines.join("; "));
    } catch (error) {
      fail(error);
    }
  };
  /** Changes the mode if it is another. Without a task, the mode follows what moves. */
  const mode = async (name) => {
    if (hasTask() || name !== "manual") return MODES[store.get("task").mode] === name || run("mode", { mode: name });
    return true;
  };
  const panel = () => store.get("panel");
  const hasTask = () => panel().has_task !== false;
  /** Returns the role of this page now: without input it only looks in the end. */
  const role = () => panel().role ?? session.role;
  const power = () => powerOf(store.get("task"), store.get("motion"));
  // A robot behind its own controller has its own state.
  const isOn = () => info.isRobot || power() === "on";
  const progress = () => progressOf(store.get("task"), store.get("motion"));
  const mayJog = () => mayMove() && isOn() && mayJogBeside(store.get("task"), store.get("motion"));
  const hasLease = () => panel().lease?.yours === true;
  const isJoined = () => store.get("link").isOpen === true && panel().engine === "joined";
  const mayControl = () => isJoined() && role() !== "viewer" && hasLease();
  const mayMove = () => mayControl() && panel().allow_motion !== false && info.remote?.motion !== false;
  /** Returns why nothing can be moved from here, in words. */
  const whyNot = () => {
    if (!store.get("link").isOpen) return t("link.lost");
    if (panel().engine !== "joined") return t("engine.gone");
    if (role() !== session.role) return t("why.idle");
    if (role() === "viewer") return t("why.viewer");
    if (!hasLease()) return t("why.lease");
    if (info.remote?.motion === false || panel().allow_motion === false) return t("why.remote");
    if (!isOn()) return t("why.off");
    return t("why.busy");
  };
  const manual = () => (store.get("task").interpreter === 2 ? true : mode("manual"));
  return Object.assign(ctx, {
    fail, run, stop, mode, manual, hasLease, hasTask, isJoined, isOn, mayControl, mayJog, mayMove, power, progress, role, whyNot,
    mm: new Units(machineUnit, "mm"),
    units: () => new Units(machineUnit, prefs.get("units") ?? machineUnit),
  });
}
