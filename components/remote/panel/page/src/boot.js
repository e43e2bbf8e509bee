// Loads the page again if a part of it did not arrive, as when the network changes meanwhile. A plain script, before all others:
// the table of texts may be what is missing.

/** Time in ms after which the page is loaded again, from when everything else has arrived or failed. */
const AGAIN_MS = 1000;

window.addEventListener("error", ({ target }) => {
  const isPart = target instanceof HTMLScriptElement || (target instanceof HTMLLinkElement && target.rel === "stylesheet");
  if (!isPart || document.documentElement.dataset.missing) return;
  // Nothing else begins: `main.js` looks for this.
  document.documentElement.dataset.missing = "true";
  const isSpanish = navigator.language.startsWith("es");
  const say = () => {
    const text = isSpanish ? "Falta una parte de la página: se carga otra vez." : "A part of the page is missing: it is loaded again.";
    document.body.innerText = text;
  };
  if (document.body) say();
  else document.addEventListener("DOMContentLoaded", say);
  const again = () => setTimeout(() => location.reload(), AGAIN_MS);
  // A page that is loaded again while its parts arrive slowly would never have them all.
  if (document.readyState === "complete") again();
  else window.addEventListener("load", again);
}, true);
