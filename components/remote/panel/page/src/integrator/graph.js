// The machine's wiring as a picture, with live values.

import { el, setText } from "../dom.js";
import { getJson, listPath, request } from "../http.js";
import { asked } from "./diagnose.js";
import { valueText } from "./tree.js";

/** Most signals with live values. */
const MAX_LIVE = 300;

/** Makes the card of the wiring. */
export function graphCard(ctx) {
  const { t, link, store, signal } = ctx;
  const pattern = el("input", { type: "search", id: "graph-pattern", placeholder: "joint.0.*", "aria-label": t("graph.pattern") });
  let texts = [];
  const { box, refresh } = asked(ctx, "graph", t("graph"), async () => {
    const patterns = pattern.value.trim().split(/\s+/).filter(Boolean);
    const svg = await (await request("GET", listPath("graph", patterns), { signal })).text();
    const picture = el("div", { class: "graph" }, parsed(svg, t("graph.broken")));
    const signals = new Set((await getJson(listPath("signals"), { signal })).map((s) => s.name));
    texts = [...picture.querySelectorAll("text.label")].map((node) => ({ node, name: node.textContent }))
      .filter(({ name }) => signals.has(name)).slice(0, MAX_LIVE);
    link.watch("graph", texts.map(({ name }) => `sig:${name}`));
    draw();
    return [picture];
  }, [pattern]);
  pattern.addEventListener("change", refresh);

  function draw() {
    const values = store.get("values");
    for (const { node, name } of texts) {
      const value = values[`sig:${name}`];
      if (value === undefined) continue;
      setText(node, `${name} = ${valueText(value)}`);
      node.classList.toggle("is-true", value?.bit === true);
    }
  }
  store.listen(draw, signal);
  signal.addEventListener("abort", () => link.watch("graph", []));
  return box;
}

/** Returns the picture as an element. The page's own rules give it its fonts, because the server permits no others. */
function parsed(svg, broken) {
  const plain = svg.replace(/<style>[^<]*<\/style>/g, "").replace(/\sstyle="fill: (#[0-9a-f]{6})"/g, ' data-colour="$1"');
  const { documentElement: root } = new DOMParser().parseFromString(plain, "image/svg+xml");
  if (root.localName !== "svg") throw new Error(broken);
  const picture = document.importNode(root, true);
  for (const node of picture.querySelectorAll("[data-colour]")) node.style.fill = node.dataset.colour;
  return picture;
}
