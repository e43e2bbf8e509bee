// The start of the page: session, socket, and the two faces, the operator's and the integrator's.

import { el } from "./dom.js";
import { currentSession, getJson, listPath, login, persistent, signIn } from "./http.js";
import { Link } from "./link.js";
import { holdMessages } from "./operator/held.js";
import { Messages, machineMessages } from "./operator/messages.js";
import { Prefs } from "./prefs.js";
import { signInForm } from "./sign_in.js";
import { Store } from "./store.js";
import { translator } from "./texts.js";
import { buildPage } from "./page.js";
import { context } from "./context.js";
import { ROBOT_PINS } from "./robot/state.js";

const prefs = new Prefs();
const store = new Store();
const messages = new Messages();
let built = new AbortController();

async function start() {
  applyLook();
  const token = login();
  let session = null;
  let refusal = null;
  try {
    session = await persistent(() => (token ? signIn(token) : currentSession()), say);
  } catch (error) {
    // A token that was used is no reason to lose the session of this tab.
    refusal = error;
    session = await persistent(currentSession, say).catch(() => null);
  }
  if (session) await run(session);
  else document.body.replaceChildren(signInForm(translator(prefs.get("language")), refusal, run));
}

async function run(session) {
  let info;
  try {
    info = await persistent(description, say);
  } catch (error) {
    document.body.replaceChildren(el("main", { class: "sign-in" }, el("p", { role: "alert" }, error.message),
      el("button", { type: "button", onclick: () => location.reload() }, translator(prefs.get("language"))("refresh"))));
    return;
  }
  const text = (key, ...rest) => translator(prefs.get("language"))(key, ...rest);
  const listenTo = machineMessages(messages, text);
  const noteHolds = holdMessages(messages, text);
  const link = new Link({
    state: (isOpen, hello) => store.replace("link", { isOpen, client: hello?.client ?? null }),
    ended: () => location.reload(),
    status: ({ type, ...parts }) => {
      for (const [part, changes] of Object.entries(parts)) {
        if (changes === null) store.replace(part, {});
        else store.merge(part, changes);
      }
      listenTo(store.get("task"));
      noteHolds(store.get("panel"));
    },
    values: ({ values }) => store.merge("values", values),
  });
  const build = () => {
    built.abort();
    built = new AbortController();
    applyLook();
    if (info.isRobot) link.watch("robot", ROBOT_PINS);
    buildPage(context({ info, session, link, store, messages, prefs, signal: built.signal, t: translator(prefs.get("language")) }));
  };
  prefs.listen((name) => ["language", "theme", "units", null].includes(name) && build(), new AbortController().signal);
}

/** Shows why the page waits. */
function say(error) {
  document.body.replaceChildren(el("main", { class: "sign-in" }, el("p", { role: "status" }, error.message)));
}

/** Asks for everything that the page needs to know of the machine. */
async function description() {
  const [info, components] = await Promise.all([getJson("/info"), getJson(listPath("components"))]);
  const has = (name) => components.some((component) => component.name === name);
  info.hasAlign = has("align");
  // A robot that moves by its own controller is the machine itself.
  info.isRobot = has("robot") && !has("motmod");
  if (!info.joints) await addJoints(info);
  return info;
}

/** Adds the joints and axes that a machine without an INI file has. */
async function addJoints(info) {
  const names = async (pattern) => (await getJson(listPath("pins", [pattern]))).map((pin) => pin.name);
  info.joints = (await names("joint.*.motor-pos-cmd")).length;
  const axes = (await names("axis.?.pos-cmd")).map((name) => name[5].toUpperCase());
  info.axes = [..."XYZABCUVW"].filter((axis) => axes.includes(axis)).slice(0, info.joints).join("");
}

function applyLook() {
  document.documentElement.lang = prefs.get("language");
  document.documentElement.dataset.theme = prefs.get("theme");
}

/** Returns whether all parts of the page have arrived; otherwise `boot.js` loads it again, and what begins now would be cut off. */
function isWhole() {
  return !document.documentElement.dataset.missing && [...document.querySelectorAll("link[rel=stylesheet]")].every((link) => link.sheet);
}

if (isWhole()) start();
