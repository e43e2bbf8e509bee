// Pins, parameters, signals, functions and threads: a tree with search, a watch list, values to set and links to make.

import { ask, card, el, field, setText, show } from "../dom.js";
import { getJson, listPath } from "../http.js";

const KINDS = ["pins", "params", "signals", "functs", "threads", "components"];
/** Most names that one branch shows at once. */
const MAX_SHOWN = 100;

/** Makes the card of the tree. */
export function treeCard(ctx) {
  const { t, signal } = ctx;
  const search = el("input", { type: "search", id: "tree-search", placeholder: "joint.*", "aria-label": t("tree.search") });
  const branches = KINDS.map((kind) => branch(ctx, kind));
  let timer = null;
  const find = () => {
    const text = search.value.trim();
    // A word alone is looked for anywhere in a name.
    const pattern = text === "" ? [] : [/[*?[]/.test(text) ? text : `*${text}*`];
    for (const b of branches) b.load(pattern);
  };
  search.addEventListener("input", () => {
    clearTimeout(timer);
    timer = setTimeout(find, 200);
  });
  signal.addEventListener("abort", () => clearTimeout(timer));
  find();
  return card("tree", t("tree"), el("div", { class: "row" }, search, el("button", { type: "button", onclick: find }, t("refresh"))), ...branches.map((b) => b.node));
}

function branch(ctx, kind) {
  const { t, signal } = ctx;
  const count = el("span", { class: "note" });
  const list = el("ul", { class: "names" });
  const node = el("details", { open: kind === "pins", "data-kind": kind }, el("summary", {}, t(`tree.${kind}`), " ", count), list);
  let round = 0;
  const load = async (pattern) => {
    const mine = ++round;
    try {
      const all = await getJson(listPath(kind, pattern), { signal });
      if (mine !== round) return;
      setText(count, String(all.length));
      const more = all.length > MAX_SHOWN ? [el("li", { class: "note" }, t("tree.more", all.length - MAX_SHOWN))] : [];
      list.replaceChildren(...all.slice(0, MAX_SHOWN).map((record) => item(ctx, kind, record)), ...more);
    } catch (error) {
      if (error.name !== "AbortError") ctx.fail(error);
    }
  };
  return { node, load };
}

function item(ctx, kind, record) {
  const { t } = ctx;
  const name = el("span", { class: "code", title: record.doc ?? "" }, record.name);
  const detail = el("span", { class: "note" }, describe(kind, record));
  if (!["pins", "params", "signals"].includes(kind)) return el("li", { class: "row spread" }, name, detail);
  const watched = kind === "signals" ? `sig:${record.name}` : record.name;
  const watch = el("button", { type: "button", class: "small", "aria-label": `${t("watch.add")} ${record.name}`, onclick: () => ctx.addWatch(watched) }, "+");
  return el("li", { class: "row spread" }, name, detail, watch);
}

function describe(kind, record) {
  switch (kind) {
    case "pins":
    case "params":
      return [kindOf(record.value), record.direction, record.signal ? `⇔ ${record.signal}` : ""].filter(Boolean).join(" ");
    case "signals":
      return `${kindOf(record.value)} · ${record.pins?.length ?? 0}`;
    case "threads":
      return `${record.period / 1000} µs · ${record.functs?.length ?? 0}`;
    case "functs":
      return record.owner_name ?? "";
    default:
      return record.doc ?? "";
  }
}

/** Returns the type of a value of the server. */
const kindOf = (value) => Object.keys(value ?? {})[0] ?? "";

/** Returns a value of the server as a text. */
export function valueText(value) {
  if (value === null || value === undefined) return "—";
  const [[kind, inner]] = Object.entries(value);
  if (kind === "bit") return inner ? "TRUE" : "FALSE";
  if (kind !== "float" || typeof inner === "string") return String(inner);
  return Number.isInteger(inner) ? String(inner) : inner.toPrecision(8).replace(/\.?0+$/, "");
}

/** Makes the card of watched values. */
export function watchCard(ctx) {
  const { link, store, t, prefs, session, signal } = ctx;
  const body = el("tbody");
  const table = el("table", { class: "grid watch", "aria-label": t("watch") },
    el("thead", {}, el("tr", {}, ...["watch.name", "watch.value", "watch.do"].map((key) => el("th", { scope: "col" }, t(key))))), body);
  const cells = new Map();

  ctx.addWatch = (name) => {
    if (!prefs.get("watch").includes(name)) prefs.set("watch", [...prefs.get("watch"), name]);
  };
  const remove = (name) => prefs.set("watch", prefs.get("watch").filter((other) => other !== name));

  async function set(name) {
    const isSignal = name.startsWith("sig:");
    const value = el("input", { name: "value", required: true, autocomplete: "off", value: cells.get(name).textContent });
    const answer = await ask(`${t("watch.set")} ${name}`, [field(t("watch.value"), value)], { confirm: t("watch.set"), cancel: t("cancel") });
    if (answer) ctx.run(isSignal ? "sets" : "setp", { name: isSignal ? name.slice(4) : name, value: answer.value });
  }
  async function connect(name) {
    const input = el("input", { name: "signal", autocomplete: "off" });
    const answer = await ask(`${t("watch.link")} ${name}`, [field(t("watch.signal"), input), el("p", { class: "note" }, t("watch.link.hint"))], { confirm: t("watch.link"), cancel: t("cancel") });
    if (!answer) return;
    if (answer.signal === "") ctx.run("unlink", { pin: name });
    else ctx.run("net", { signal: answer.signal, pins: name });
  }

  prefs.listen((name) => {
    if (name !== null && name !== "watch") return;
    cells.clear();
    const may = ctx.role() === "integrator";
    body.replaceChildren(...prefs.get("watch").map((pin) => {
      const cell = el("td", { class: "number code" }, "…");
      cells.set(pin, cell);
      const button = (key, sign, action) => el("button", { type: "button", class: "small", "aria-label": `${t(key)} ${pin}`, title: t(key), onclick: action }, sign);
      const tasks = may ? [button("watch.set", "✎", () => set(pin)), pin.startsWith("sig:") ? null : button("watch.link", "⇔", () => connect(pin))] : [];
      return el("tr", { "data-name": pin }, el("th", { scope: "row", class: "code" }, pin), cell, el("td", { class: "row" }, ...tasks,
        button("scope.add", "∿", () => ctx.addTrace(pin)), button("watch.remove", "✕", () => remove(pin))));
    }));
    link.watch("watch", prefs.get("watch"));
    draw();
  }, signal);
  function draw() {
    const values = store.get("values");
    for (const [pin, cell] of cells) if (pin in values) setText(cell, valueText(values[pin]));
  }
  store.listen(draw, signal);
  signal.addEventListener("abort", () => link.watch("watch", []));
  const clear = el("button", { type: "button", onclick: () => prefs.set("watch", []) }, t("watch.clear"));
  const role = el("p", { id: "watch-role", class: "note" }, t("watch.role"));
  store.listen(() => show(role, ctx.role() !== "integrator"), signal);
  return card("watch", t("watch"), table, role, el("div", { class: "row" }, clear));
}
