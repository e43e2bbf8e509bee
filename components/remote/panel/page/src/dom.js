// Elements of the page.

/**
 * Makes an element. Properties that begin with "on" are listeners; "class", "aria-…", "data-…" and "role" are
 * attributes; all others are properties of the element. Children are elements or texts; null and false are left out.
 */
export function el(tag, properties = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (name === "style") Object.assign(node.style, value);
    else if (name === "class" || name === "role" || name === "for" || name === "list" || /^(aria|data)-/.test(name)) {
      node.setAttribute(name, value);
    } else node[name] = value;
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return node;
}

/** Makes a card: a region of the page with a heading. */
export function card(id, title, ...children) {
  const heading = el("h2", { id: `${id}-title` }, title);
  return el("section", { id, class: "card", "aria-labelledby": heading.id }, heading, ...children);
}

/** Makes a labelled field. */
export function field(label, input, unit) {
  return el("label", { class: "field" }, el("span", {}, label), input, unit ? el("span", { class: "unit" }, unit) : null);
}

/** Sets a text only where it differs: a screen reader reads changes. */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Shows or hides an element. */
export function show(node, is) {
  if (node.hidden === is) node.hidden = !is;
}

/** Sets whether a control can be used. */
export function enable(node, is) {
  if (node.disabled === is) node.disabled = !is;
}

/** Sets an attribute that is true or false. */
export function mark(node, attribute, is) {
  const text = is ? "true" : "false";
  if (node.getAttribute(attribute) !== text) node.setAttribute(attribute, text);
}

/** Asks a question in a dialog. Resolves to the values of its fields, or to null if it was cancelled. */
export function ask(title, fields, { confirm, cancel }) {
  return new Promise((resolve) => {
    const form = el("form", { method: "dialog" }, el("h2", { id: "dialog-title" }, title), ...fields);
    const dialog = el("dialog", { "aria-labelledby": "dialog-title" }, form);
    const close = (value) => {
      dialog.close();
      dialog.remove();
      resolve(value);
    };
    form.append(
      el(
        "div",
        { class: "row end" },
        el("button", { type: "button", onclick: () => close(null) }, cancel),
        el("button", { type: "submit", class: "primary" }, confirm),
      ),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      close(Object.fromEntries(new FormData(form)));
    });
    dialog.addEventListener("cancel", (event) => {
      event.preventDefault();
      close(null);
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
