// Coordinate systems, touch-off and the tool table.

import { ask, card, el, enable, field } from "../dom.js";
import { AXES } from "../format.js";
import { holdButton } from "../hold.js";
import { getJson } from "../http.js";
import { systemName } from "./positions.js";

/** Makes the card of touch-off and coordinate systems. */
export function offsetsCard(ctx) {
  const { info, store, t, signal } = ctx;
  const axes = [...info.axes.toLowerCase()];
  const value = el("input", { type: "number", id: "touch-off-value", step: "any", value: "0" });
  const buttons = axes.map((axis) =>
    holdButton(axis.toUpperCase(), t("hold.hint"), () => touchOff(axis), { "aria-label": `${t("touchoff")} ${axis.toUpperCase()}` }),
  );
  const table = el("table", { class: "grid", "aria-label": t("offsets") });
  const choose = el(
    "select", { id: "system", onchange: () => select(choose.value) },
    ...Array.from({ length: 9 }, (_, i) => el("option", { value: systemName(i + 1) }, systemName(i + 1))),
  );

  async function touchOff(axis) {
    const number = Number(value.value);
    if (value.value === "" || !Number.isFinite(number)) return;
    const there = axis === "a" || axis === "b" || axis === "c" ? number : ctx.units().read(number);
    if (!(await ctx.mode("mdi"))) return;
    if (await ctx.run("touch-off", { axis: axis.toUpperCase(), value: there, system: 0 })) refresh();
  }
  async function select(name) {
    if (await ctx.mode("mdi")) await ctx.run("mdi", { text: name });
  }
  async function refresh() {
    try {
      const { systems, g92 } = await getJson("/offsets", { signal });
      const current = systemName(store.get("task").system);
      const rows = [...systems, { name: "G92", offset: g92, rotation: 0 }];
      table.replaceChildren(
        el("thead", {}, el("tr", {}, el("th", { scope: "col" }, ""), ...axes.map((a) => el("th", { scope: "col" }, a.toUpperCase())), el("th", { scope: "col" }, "R"))),
        el("tbody", {}, ...rows.map((s) =>
          el("tr", { class: s.name === current ? "current" : "" }, el("th", { scope: "row" }, s.name),
            ...axes.map((a) => el("td", { class: "number" }, ctx.units().text(s.offset[AXES.indexOf(a)] ?? 0, a))),
            el("td", { class: "number" }, (s.rotation ?? 0).toFixed(2))))),
      );
    } catch (error) {
      if (error.name !== "AbortError") ctx.fail(error);
    }
  }

  let known = "";
  store.listen(() => {
    const task = store.get("task");
    const may = ctx.hasTask() && ctx.mayMove() && ctx.isOn() && !task.interpreter;
    for (const node of [...buttons, choose]) enable(node, may);
    if (document.activeElement !== choose && task.system) choose.value = systemName(task.system);
    const state = JSON.stringify([task.system, task.g5x_offset, task.g92_offset, task.rotation, ctx.units().name]);
    if (task.system && state !== known) {
      known = state;
      refresh();
    }
  }, signal);
  return card(
    "offsets", t("offsets"),
    el("div", { class: "row" }, field(t("system"), choose), field(t("touchoff.value"), value, ctx.units().unit("x"))),
    el("div", { class: "row", role: "group", "aria-label": t("touchoff") }, el("span", {}, t("touchoff")), ...buttons),
    el("details", {}, el("summary", {}, t("offsets.all")), el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": t("offsets.all") }, table)),
  );
}

const COLUMNS = ["number", "pocket", "z", "x", "diameter", "comment"];

/** Makes the card of tools: the tool in the spindle, and the table. */
export function toolsCard(ctx) {
  const { store, t, signal } = ctx;
  const now = el("p", { class: "row spread" });
  const table = el("table", { class: "grid", "aria-label": t("tools.table") });

  async function refresh() {
    try {
      draw(await getJson("/tools", { signal }));
    } catch (error) {
      if (error.name !== "AbortError") ctx.fail(error);
    }
  }
  function draw(tools) {
    const head = COLUMNS.map((c) => el("th", { scope: "col" }, t(`tools.${c}`)));
    table.replaceChildren(el("thead", {}, el("tr", {}, ...head, el("th", { scope: "col" }, t("tools.change")))), el("tbody", {}, ...tools.map(row)));
    allow();
  }
  function row(tool) {
    const unit = ctx.units();
    const { number, pocket, diameter, comment, offset } = tool;
    const cells = [number, pocket, unit.text(offset[2]), unit.text(offset[0]), unit.text(diameter), comment];
    const change = el("button", { type: "button", class: "small", "aria-label": `${t("tools.change")} T${number}`, onclick: () => edit(tool) }, "✎");
    return el("tr", { "data-tool": number }, ...cells.map((c, i) => el("td", { class: i < 5 ? "number" : "" }, String(c))), el("td", {}, change));
  }
  async function edit({ number, offset, diameter }) {
    const unit = ctx.units();
    const before = { z: unit.show(offset[2]), x: unit.show(offset[0]), diameter: unit.show(diameter) };
    const fields = Object.entries(before).map(([name, value]) =>
      field(t(`tools.${name}`), el("input", { name, type: "number", step: "any", required: true, value: String(value) }), unit.unit("x")));
    const answer = await ask(`${t("tools.change")} T${number}`, fields, { confirm: t("tools.change"), cancel: t("cancel") });
    if (!answer) return;
    // What was not touched keeps its digits.
    const changed = Object.keys(before).filter((name) => Number(answer[name]) !== before[name]);
    if (changed.length === 0 || !(await ctx.mode("mdi"))) return;
    const values = Object.fromEntries(changed.map((name) => [name, unit.read(Number(answer[name]))]));
    if (await ctx.run("tool-offset", { tool: number, ...values })) refresh();
  }
  function allow() {
    const task = store.get("task");
    const may = ctx.hasTask() && ctx.mayMove() && ctx.isOn() && !task.interpreter;
    for (const button of table.querySelectorAll("button")) enable(button, may);
  }

  let known;
  store.listen(() => {
    const task = store.get("task");
    now.replaceChildren(
      el("span", {}, `${t("tools.now")} T${task.tool ?? 0}`),
      el("span", {}, task.tool_prepared ? `${t("tools.next")} T${task.tool_prepared}` : ""),
    );
    const state = `${task.tool} ${task.tool_offset} ${ctx.units().name}`;
    if (state !== known) {
      known = state;
      refresh();
    }
    allow();
  }, signal);
  return card("tools", t("tools"), now, el("details", {}, el("summary", {}, t("tools.table")),
    el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": t("tools.table") }, table)));
}
