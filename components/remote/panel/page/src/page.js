// The frame of the page: the bar at the top, the cards, the bar at the bottom of a phone.

import { cameraCard } from "./align/camera.js";
import { marksCard } from "./align/marks.js";
import { ask, el, enable, mark, setText, show } from "./dom.js";
import { releaseAll } from "./hold.js";
import { signOut } from "./http.js";
import { findingsCard, flightCard, threadsCard } from "./integrator/diagnose.js";
import { latencyCard } from "./integrator/latency.js";
import { graphCard } from "./integrator/graph.js";
import { orderCard } from "./integrator/order.js";
import { scopeCard } from "./integrator/scope.js";
import { treeCard, watchCard } from "./integrator/tree.js";
import { holdBanner } from "./operator/holds.js";
import { jogCard } from "./operator/jog.js";
import { machineCard } from "./operator/machine.js";
import { mdiCard } from "./operator/mdi.js";
import { messagesCard, toasts, toolPrompt } from "./operator/messages.js";
import { offsetsCard, toolsCard } from "./operator/offsets.js";
import { overridesCard, spindleCard } from "./operator/overrides.js";
import { positionsCard } from "./operator/positions.js";
import { probeCard } from "./operator/probe.js";
import { programsCard } from "./operator/programs.js";
import { runCard } from "./operator/run.js";
import { progressOf } from "./operator/states.js";
import { robotCard } from "./robot/card.js";
import { robotOf } from "./robot/state.js";
import { LANGUAGES } from "./texts.js";
import { viewCard } from "./view/card.js";

/** Cards of the operator: the place on a wide screen, the group on a phone. */
const OPERATOR = [
  ["left", "all", positionsCard], ["left", "move", machineCard], ["left", "move", jogCard],
  ["centre", "view", viewCard], ["centre", "job", runCard], ["centre", "job", programsCard],
  ["right", "job", overridesCard], ["right", "mdi", mdiCard], ["right", "more", spindleCard], ["right", "more", offsetsCard],
  ["right", "more", probeCard], ["right", "more", toolsCard], ["right", "more", messagesCard],
];
const GROUPS = ["move", "view", "job", "mdi", "more"];
const INTEGRATOR = [
  ["left", treeCard], ["centre", watchCard], ["centre", scopeCard], ["centre", graphCard], ["right", findingsCard], ["right", orderCard],
  ["right", latencyCard], ["right", threadsCard], ["right", flightCard],
];

/** Cards of the alignment of a part by marks. */
const ALIGN = [
  ["left", positionsCard], ["left", machineCard], ["left", jogCard], ["centre", cameraCard], ["centre", runCard], ["centre", programsCard],
  ["right", marksCard], ["right", messagesCard],
];
/** Cards of a robot behind its own controller. */
const ROBOT = [["left", robotCard], ["centre", viewCard], ["right", messagesCard]];
/** Cards of the pages that show all of them on every screen. */
const WHOLE = { integrate: INTEGRATOR, align: ALIGN, robot: ROBOT };

/** Returns the pages that this machine has; the first one is shown first. */
const pagesOf = (info) => [info.isRobot ? "robot" : "operate", ...(info.hasAlign ? ["align"] : []), "integrate"];

/** Builds the page anew. */
export function buildPage(ctx) {
  const { prefs, t, signal } = ctx;
  const main = el("main", { id: "main" });
  const nav = el("nav", { class: "groups", "aria-label": t("groups") }, ...GROUPS.map((group) =>
    el("button", { type: "button", "data-group": group, onclick: () => prefs.set("group", group) }, t(`group.${group}`))));
  document.body.replaceChildren(
    el("a", { class: "skip", href: "#main" }, t("skip")), topBar(ctx), linkBanner(ctx), idleBanner(ctx), holdBanner(ctx), toolPrompt(ctx), main, nav, toasts(ctx),
  );
  let face = new AbortController();
  // The release of a button that is removed never arrives.
  const leave = () => {
    releaseAll();
    face.abort();
  };
  signal.addEventListener("abort", leave);
  let shown = null;
  prefs.listen(() => {
    document.body.dataset.group = prefs.get("group");
    for (const button of nav.children) mark(button, "aria-pressed", button.dataset.group === prefs.get("group"));
    const page = pageOf(ctx);
    if (page === shown) return;
    shown = page;
    leave();
    face = new AbortController();
    document.body.dataset.page = page;
    main.replaceChildren(...columns(page, { ...ctx, signal: face.signal }));
  }, signal);
  keepAwake(ctx);
}

/** Returns the chosen page; the first one where this machine has no such page. */
function pageOf({ info, prefs }) {
  const page = prefs.get("page");
  const pages = pagesOf(info);
  return pages.includes(page) ? page : pages[0];
}

function columns(page, ctx) {
  const places = { left: [], centre: [], right: [] };
  if (WHOLE[page]) for (const [place, make] of WHOLE[page]) places[place].push(make(ctx));
  else {
    for (const [place, group, make] of OPERATOR) {
      const box = make(ctx);
      box.dataset.group = group;
      places[place].push(box);
    }
  }
  return Object.entries(places).map(([place, boxes]) => el("div", { class: `column ${place}` }, ...boxes));
}

/** Returns the stop that a key gives, as with LinuxCNC's screens: F1 is the e-stop, Escape aborts, unless it closes a question. */
function stopOfKey({ key, target }) {
  if (key === "F1") return "estop";
  const asks = document.querySelector("dialog[open]") !== null || (target instanceof Element && target.closest("dialog") !== null);
  return key === "Escape" && !asks ? "abort" : null;
}

function topBar(ctx) {
  const { info, session, store, prefs, t, signal } = ctx;
  const pages = pagesOf(info).map((page) =>
    el("button", { type: "button", "data-page": page, onclick: () => prefs.set("page", page) }, t(`page.${page}`)));
  const lease = el("button", { type: "button", id: "lease", onclick: changeLease });
  const holder = el("span", { class: "note", id: "lease-holder" });
  const stop = el("button", { type: "button", id: "estop", class: "estop", title: t("estop.key"), "aria-keyshortcuts": "F1", onclick: () => ctx.stop("estop") }, t("estop"));
  const abort = el("button", { type: "button", id: "abort", class: "danger", title: t("abort.key"), "aria-keyshortcuts": "Escape", onclick: () => ctx.stop("abort") }, t("abort"));
  window.addEventListener("keydown", (event) => {
    const name = stopOfKey(event);
    if (!name) return;
    event.preventDefault();
    if (!event.repeat) ctx.stop(name);
  }, { signal, capture: true });
  const language = el("select", { "aria-label": t("language"), id: "language", onchange: () => prefs.set("language", language.value) },
    ...LANGUAGES.map(([code, name]) => el("option", { value: code, selected: code === prefs.get("language"), lang: code }, name)));
  const theme = el("button", { type: "button", id: "theme", "aria-label": t("theme"), title: t("theme"),
    onclick: () => prefs.set("theme", prefs.get("theme") === "dark" ? "light" : "dark") }, "◐");
  const manual = el("a", { id: "manual", href: "manual/index.html", target: "_blank", title: t("manual"), "aria-label": t("manual") }, "?");
  const leave = el("button", { type: "button", id: "sign-out", onclick: () => endSession(ctx) }, t("sign.out"));
  const user = el("span", { class: "note user", id: "user" });

  async function changeLease() {
    const panel = store.get("panel");
    const isOther = panel.lease && !panel.lease.yours;
    if (isOther && !(await ask(t("lease.force", panel.lease.user), [], { confirm: t("lease.take"), cancel: t("cancel") }))) return;
    try {
      await ctx.link.ask({ type: "lease", do: panel.lease?.yours ? "give" : "take", force: Boolean(isOther) });
    } catch (error) {
      ctx.fail(error);
    }
  }

  prefs.listen(() => {
    for (const button of pages) mark(button, "aria-pressed", button.dataset.page === pageOf(ctx));
  }, signal);
  store.listen(() => {
    const [panel, link] = [store.get("panel"), store.get("link")];
    const { lease: held } = panel;
    setText(lease, held?.yours ? t("lease.give") : t("lease.take"));
    mark(lease, "aria-pressed", held?.yours === true);
    enable(lease, link.isOpen && ctx.role() !== "viewer");
    const isKnown = link.isOpen && panel.lease !== undefined;
    setText(holder, !isKnown ? "" : held ? (held.yours ? t("lease.yours") : t("lease.held", held.user)) : t("lease.free"));
    // Everybody who is signed in stops the machine.
    for (const button of [stop, abort]) enable(button, link.isOpen);
    setText(user, `${session.user ?? ""} · ${t(`role.${ctx.role()}`)}`);
  }, signal);
  return el("header", { class: "top" },
    el("h1", {}, info.machine ?? info.instance), info.simulated ? el("span", { class: "chip" }, t("simulated")) : null,
    el("div", { class: "row tabs", role: "group", "aria-label": t("pages") }, ...pages),
    el("div", { class: "row" }, lease, holder), el("span", { class: "grow" }), manual, language, theme,
    user, leave, abort, stop);
}

async function endSession(ctx) {
  await signOut().catch(ctx.fail);
  location.reload();
}

/** Says that nobody has used the page for so long that it only looks, and how to sign in again. */
function idleBanner(ctx) {
  const { session, store, t, signal } = ctx;
  const again = el("button", { type: "button", id: "sign-in-again", onclick: () => endSession(ctx) }, t("sign.again"));
  const box = el("div", { class: "banner", role: "status", hidden: true, id: "idle-banner" }, t("why.idle"), again);
  store.listen(() => show(box, store.get("link").isOpen === true && ctx.role() !== session.role), signal);
  return box;
}

/** Says at once that the server or the engine is gone. */
function linkBanner(ctx) {
  const { store, t, signal } = ctx;
  const text = el("span");
  const box = el("div", { class: "banner", role: "alert", hidden: true, id: "link-banner" }, text);
  store.listen(() => {
    const [link, panel] = [store.get("link"), store.get("panel")];
    const isLost = link.isOpen === false;
    const engine = panel.engine ?? "joined";
    show(box, isLost || engine !== "joined" || Boolean(panel.outdated));
    setText(text, isLost ? t("link.lost") : engine !== "joined" ? t("engine.gone") : t("stops.gone", panel.outdated));
  }, signal);
  return box;
}

/** Keeps the screen awake while a job runs. */
function keepAwake({ store, signal }) {
  let lock = null;
  let isAsked = false;
  const release = () => {
    lock?.release();
    lock = null;
  };
  const draw = async () => {
    const isRunning = Boolean(progressOf(store.get("task"), store.get("motion")) || robotOf(store.get("values"))?.busy);
    if (!isRunning) release();
    if (!isRunning || lock || isAsked || document.hidden || !navigator.wakeLock) return;
    isAsked = true;
    try {
      lock = await navigator.wakeLock.request("screen");
      lock.addEventListener("release", () => { lock = null; });
    } catch {
      // The browser may refuse (battery, no secure page): the screen follows its own settings.
    }
    isAsked = false;
  };
  store.listen(draw, signal);
  document.addEventListener("visibilitychange", draw, { signal });
  signal.addEventListener("abort", release);
}
