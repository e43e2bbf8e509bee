// Buttons that act only while, or after, they are held: nothing moves by an accidental touch.

import { el } from "./dom.js";

/** Time in ms for which a button is held before it acts. */
const HOLD_MS = 600;
/** Time in ms for which a jog button is held before the jog begins. */
export const JOG_HOLD_MS = 150;

/** Elements that are held, with the function that ends the hold. */
const HOLDS = new Map();
/** Jogs that have not ended. */
const JOGS = new Set();

/** Ends each hold in progress, as if all buttons were released. */
export function releaseAll() {
  for (const end of [...HOLDS.values()]) end();
}

/** Returns whether an element is held and can still be released. */
export const isHeld = (node) => HOLDS.has(node) && node.isConnected && !node.disabled;

/** Notes a jog `{ isHeld, end }`; returns the function that notes that the machine has ended it. */
export function noteJog(jog) {
  JOGS.add(jog);
  return () => JOGS.delete(jog);
}

/** Returns whether something holds each jog, and ends those that nothing holds. */
export function areJogsHeld() {
  const lost = [...JOGS].filter((jog) => !jog.isHeld());
  for (const jog of lost) jog.end();
  return lost.length === 0;
}

for (const name of ["blur", "pagehide"]) window.addEventListener(name, releaseAll);
document.addEventListener("visibilitychange", () => document.hidden && releaseAll());

/**
 * Watches an element for a hold by pointer, Enter or space. `begin` is called after `delay` ms, `end` once when the hold
 * ends after that: on release, at another key, when the pointer leaves, on blur, when the page is hidden, when the element is disabled.
 */
export function watchHold(node, { delay, begin, end = () => {} }) {
  let timer = null;
  let active = false;
  let pointer = null;

  const stop = () => {
    // A touch while the element was disabled held nothing, but had a pointer.
    pointer = null;
    if (timer === null && !active) return;
    clearTimeout(timer);
    timer = null;
    HOLDS.delete(node);
    node.classList.remove("holding");
    if (active) {
      active = false;
      end();
    }
  };
  const start = () => {
    if (node.disabled || timer !== null || active) return;
    HOLDS.set(node, stop);
    node.classList.add("holding");
    timer = setTimeout(() => {
      timer = null;
      if (node.disabled || !node.isConnected) return stop();
      active = true;
      begin();
    }, delay);
  };

  node.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || pointer !== null) return;
    pointer = event.pointerId;
    start();
  });
  const isOurs = (event) => event.pointerId === pointer;
  for (const name of ["pointerup", "pointercancel", "pointerleave", "lostpointercapture"]) {
    node.addEventListener(name, (event) => isOurs(event) && stop());
  }
  node.addEventListener("contextmenu", (event) => event.preventDefault());
  node.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return stop();
    event.preventDefault();
    if (!event.repeat) start();
  });
  node.addEventListener("keyup", stop);
  node.addEventListener("blur", stop);
  new MutationObserver(() => node.disabled && stop()).observe(node, { attributeFilter: ["disabled"] });
}

/** Makes a button that acts once, after it was held. */
export function holdButton(label, hint, action, properties = {}) {
  const { class: names = "", ...others } = properties;
  const button = el("button", { type: "button", class: `hold ${names}`, title: hint, ...others }, label);
  button.setAttribute("aria-description", hint);
  button.style.setProperty("--hold", `${HOLD_MS}ms`);
  watchHold(button, { delay: HOLD_MS, begin: action });
  return button;
}
