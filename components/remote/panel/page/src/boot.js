// Loads the page again if a part of it did not arrive, as when the network changes meanwhile. A plain script, before all others:
// the table of texts may be what is missing.

/** Time in ms after which the page is loaded again. */
const AGAIN_MS = 1000;

window.addEventListener("error", ({ target }) => {
  const isPart = target instanceof HTMLScriptElement || (target instanceof HTMLLinkElement && target.rel === "stylesheet");
  if (!isPart) return;
  const isSpanish = navigator.language.startsWith("es");
  const say = () => {
    const text = isSpanish ? "Falta una parte de la página: se carga otra vez." : "A part of the page is missing: it is loaded again.";
    document.body.innerText = text;
  };
  if (document.body) say();
  else document.addEventListener("DOMContentLoaded", say);
  setTimeout(() => location.reload(), AGAIN_MS);
}, true);
