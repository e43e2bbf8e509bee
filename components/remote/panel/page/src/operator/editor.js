// A program as text that a person edits: a new one, or one that is stored.

import { el, field, setText } from "../dom.js";
import { programPath, request, storeProgram } from "../http.js";

/** Longest program that is edited here, in bytes. */
const MAX_BYTES = 1_000_000;

/** Opens a program in a dialog, or an empty one. Resolves to the name under which it was stored, or to null. */
export async function editProgram(ctx, file) {
  const { t } = ctx;
  let stored = "";
  if (file) {
    try {
      const bytes = await (await request("GET", programPath(file))).arrayBuffer();
      if (bytes.byteLength > MAX_BYTES) throw new Error(t("editor.large", MAX_BYTES / 1e6));
      stored = decoded(bytes);
      if (stored === null) throw new Error(t("editor.bytes"));
    } catch (error) {
      ctx.fail(error);
      return null;
    }
  }
  // A text area has lines that end with LF alone.
  const end = stored.includes("\r\n") ? "\r\n" : "\n";
  const first = stored.replaceAll("\r\n", "\n");
  return new Promise((resolve) => {
    const name = el("input", { type: "text", id: "editor-name", value: file ?? "", required: true, maxLength: 200, autocomplete: "off" });
    const area = el("textarea", { id: "editor-text", class: "code", value: first, rows: 22, spellcheck: false, "aria-label": t("editor.text") });
    const note = el("p", { class: "note", role: "status", id: "editor-note" });
    const save = el("button", { type: "submit", class: "primary", id: "editor-save" }, t("editor.save"));
    const leave = el("button", { type: "button", id: "editor-cancel", onclick: give }, t("cancel"));
    const form = el("form", {}, el("h2", { id: "editor-title" }, t("editor")), field(t("editor.name"), name), area, note, el("div", { class: "row end" }, leave, save));
    const dialog = el("dialog", { class: "editor", "aria-labelledby": "editor-title" }, form);
    let isWarned = false;

    const close = (result) => {
      dialog.close();
      dialog.remove();
      resolve(result);
    };
    /** Leaves; what is not stored is discarded the second time only. */
    function give() {
      if (area.value === first || isWarned) return close(null);
      isWarned = true;
      setText(note, t("editor.unsaved"));
    }
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      save.disabled = true;
      try {
        close(await storeProgram(name.value.trim(), area.value.replaceAll("\n", end)));
      } catch (error) {
        setText(note, error.message);
      }
      save.disabled = false;
    });
    area.addEventListener("input", () => { isWarned = false; });
    dialog.addEventListener("cancel", (event) => {
      event.preventDefault();
      give();
    });
    document.body.append(dialog);
    dialog.showModal();
    (file ? area : name).focus();
  });
}

/** Returns the text of bytes in UTF-8, or null. */
function decoded(bytes) {
  try {
    return new TextDecoder("utf-8", { fatal: true, ignoreBOM: true }).decode(bytes);
  } catch {
    return null;
  }
}
