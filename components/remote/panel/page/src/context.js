// What the cards share: commands with their refusals, modes, rights.

import { Units } from "./format.js";
import { MODES } from "./operator/states.js";

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
  /** Changes the mode if it is another. */
  const mode = async (name) => MODES[store.get("task").mode] === name || run("mode", { mode: name });
  const panel = () => store.get("panel");
  const hasLease = () => panel().lease?.yours === true;
  const isJoined = () => store.get("link").isOpen === true && panel().engine === "joined";
  const mayControl = () => isJoined() && session.role !== "viewer" && hasLease();
  const mayMove = () => mayControl() && panel().allow_motion !== false && info.remote?.motion !== false;
  /** Returns why nothing can be moved from here, in words. */
  const whyNot = () => {
    if (!store.get("link").isOpen) return t("link.lost");
    if (panel().engine !== "joined") return t("engine.gone");
    if (session.role === "viewer") return t("why.viewer");
    if (!hasLease()) return t("why.lease");
    if (info.remote?.motion === false || panel().allow_motion === false) return t("why.remote");
    if (store.get("task").state !== 2) return t("why.off");
    return t("why.busy");
  };
  const manual = () => (store.get("task").interpreter === 2 ? true : mode("manual"));
  return Object.assign(ctx, {
    fail, run, mode, manual, hasLease, isJoined, mayControl, mayMove, whyNot,
    mm: new Units(machineUnit, "mm"),
    units: () => new Units(machineUnit, prefs.get("units") ?? machineUnit),
  });
}
