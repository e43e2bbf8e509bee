// The list of programs, uploads, what programs have written, and the program that is open.

import { ask, card, el, enable, setText } from "../dom.js";
import { bytes } from "../format.js";
import { UPLOADS, getJson, programName, programPath, request, storeProgram } from "../http.js";
import { editProgram } from "./editor.js";
import { Listing, Program } from "./listing.js";

/** Names of cutter-location files: no task runs them, they are shown. */
const CUTTER = /\.(apt|cl|cls|aptsource)$/i;
/** Number of the program text that was read last: a program that is stored again has another one. */
let version = 0;

/** Makes the card of programs. */
export function programsCard(ctx) {
  const { store, t, signal } = ctx;
  const list = el("ul", { class: "files", "aria-label": t("programs") });
  const input = el("input", { type: "file", id: "upload", class: "unseen", multiple: true, accept: ".ngc,.nc,.gcode,.tap,.txt,.cnc,.apt,.cl,.cls,.aptsource" });
  const name = el("h3", { class: "file" }, t("program.none"));
  const note = el("p", { class: "note", role: "status" });
  const listing = new Listing(t, (line) => {
    listing.choose(line);
    store.merge("program", { chosen: line });
  });
  const fresh = el("button", { type: "button", id: "program-new", onclick: () => edit(null) }, t("program.new"));
  const files = el("details", { open: true }, el("summary", {}, t("programs")), list);
  const written = el("ul", { class: "files", id: "output", "aria-label": t("output") });
  const output = el("details", { ontoggle: () => { if (output.open) refreshOutput(); } }, el("summary", { id: "output-open" }, t("output")), written);
  let loading = null;
  // A page that was built again reads it again.
  let opened;
  // A file that is shown until the task opens another.
  let shown = null;

  async function refresh() {
    try {
      const all = await getJson("/programs", { signal });
      list.replaceChildren(...(all.length > 0 ? all.map(item) : [el("li", { class: "note" }, t("programs.empty"))]));
    } catch (error) {
      ctx.fail(error);
    }
  }

  function item(file) {
    const button = el("button", { type: "button", class: "plain", onclick: () => open(file.name) }, file.name);
    const remove = el("button", { type: "button", class: "small", "aria-label": `${t("program.delete")} ${file.name}`, onclick: () => removeFile(file.name) }, "✕");
    const change = el("button", { type: "button", class: "small edit", "aria-label": `${t("program.edit")} ${file.name}`, onclick: () => edit(file.name), disabled: ctx.role() === "viewer" }, "✎");
    // The machine's own programs stay: an edited one is stored as an upload.
    const isOwn = !file.name.startsWith(UPLOADS);
    return el("li", { class: "row spread" }, button, el("span", { class: "note" }, bytes(file.bytes)), change, isOwn ? null : remove);
  }

  async function refreshOutput() {
    try {
      const all = await getJson("/output", { signal });
      written.replaceChildren(...(all.length > 0 ? all.map(writtenItem) : [el("li", { class: "note" }, t("output.empty"))]));
    } catch (error) {
      ctx.fail(error);
    }
  }

  function writtenItem(file) {
    const button = el("button", { type: "button", class: "plain", "aria-label": `${t("output.get")} ${file.name}`, onclick: () => download(file.name) }, file.name);
    return el("li", { class: "row spread" }, button, el("span", { class: "note" }, bytes(file.bytes)));
  }

  /** Stores a file that a program has written on this computer. */
  async function download(file) {
    try {
      const answer = await request("GET", `/output/${encodeURIComponent(file)}`, { signal });
      const link = URL.createObjectURL(await answer.blob());
      el("a", { href: link, download: file.split("/").at(-1) }).click();
      URL.revokeObjectURL(link);
    } catch (error) {
      ctx.fail(error);
    }
  }

  /** Opens a program in the task; a cutter-location file is shown, and played over the stock. */
  function open(file) {
    shown = null;
    if (!CUTTER.test(file)) {
      ctx.run("open", { program: file });
      return;
    }
    shown = { file, beside: inTask() };
    setText(note, t("program.cutter", file));
    load(file);
  }

  const inTask = () => programName(store.get("task").file) || null;

  async function edit(file) {
    const name = await editProgram(ctx, file);
    if (name !== null) stored(name);
  }

  /** Shows a program that was stored; one that is open is read again. */
  function stored(name) {
    setText(note, t("program.uploaded", name));
    if (opened === name) load(name);
    refresh();
  }

  async function removeFile(file) {
    if (!(await ask(`${t("program.delete")} ${file}?`, [], { confirm: t("program.delete"), cancel: t("cancel") }))) return;
    try {
      await request("DELETE", programPath(file));
      if (shown?.file === file) shown = null;
    } catch (error) {
      ctx.fail(error);
    }
    refresh();
  }

  async function upload(chosen) {
    for (const file of chosen) {
      setText(note, t("program.uploading", file.name));
      try {
        stored(await storeProgram(file.name, file));
      } catch (error) {
        setText(note, "");
        ctx.fail(error);
      }
    }
  }
  input.addEventListener("change", () => {
    upload([...input.files]);
    input.value = "";
  });

  async function load(file) {
    loading?.abort();
    loading = new AbortController();
    const { signal: mine } = loading;
    // After a page was built again, its other cards have read the program already.
    const isKnown = opened === undefined && store.get("program").name === file;
    opened = file;
    if (!isKnown) store.replace("program", { name: file, lines: 0, version: ++version, isShown: shown !== null });
    setText(name, file ?? t("program.none"));
    listing.open(null);
    if (!file) return;
    try {
      const text = await request("GET", programPath(file), { signal: mine });
      const program = new Program(file, await text.arrayBuffer());
      listing.open(program);
      store.merge("program", { lines: program.lines });
    } catch (error) {
      if (error.name !== "AbortError") ctx.fail(error);
    }
  }

  store.listen(() => {
    const [motion, task] = [store.get("motion"), store.get("task")];
    // What runs is what is seen.
    if (shown && (shown.beside !== inTask() || task.interpreter)) shown = null;
    const file = shown?.file ?? inTask();
    if (file !== opened) load(file);
    listing.mark(task.interpreter ? motion.line || task.line || 0 : 0);
    for (const control of [input, fresh]) enable(control, ctx.role() !== "viewer");
  }, signal);
  signal.addEventListener("abort", () => loading?.abort());
  refresh();

  const box = card(
    "programs", t("program"), name, note, listing.node, files, output,
    el("div", { class: "row" }, el("label", { class: "button", for: "upload" }, t("program.upload")), input, fresh,
      el("button", { type: "button", onclick: () => { refresh(); if (output.open) refreshOutput(); } }, t("refresh"))),
  );
  box.addEventListener("dragover", (event) => event.preventDefault());
  box.addEventListener("drop", (event) => {
    event.preventDefault();
    upload([...event.dataTransfer.files]);
  });
  return box;
}
