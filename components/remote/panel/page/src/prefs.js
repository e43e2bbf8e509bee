// What a person has chosen, kept by the browser.

const KEY = "ferrule-panel";
const FIRST = {
  language: navigator.language.startsWith("es") ? "es" : "en",
  theme: matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark",
  position: "work", units: null, step: "0", mdi: [], watch: [], traces: [], trigger: "", group: "move", page: "operate", colourBy: "tool", way: "planned", laid: "auto",
  stock: { isLive: false, box: [[null, null, null], [null, null, null]], diameter: null, shape: "table" },
};

/** Choices, with listeners. */
export class Prefs {
  constructor() {
    this.listeners = new Set();
    this.values = { ...FIRST };
    try {
      Object.assign(this.values, JSON.parse(localStorage.getItem(KEY) ?? "{}"));
    } catch {
      // Damaged or forbidden storage: the first choices hold.
    }
  }

  get(name) {
    return this.values[name];
  }

  set(name, value) {
    this.values[name] = value;
    try {
      localStorage.setItem(KEY, JSON.stringify(this.values));
    } catch {
      // Without storage choices last as long as the page.
    }
    for (const listener of [...this.listeners]) listener(name);
  }

  /** Calls `listener` now and after changes, until the signal. */
  listen(listener, signal) {
    this.listeners.add(listener);
    signal.addEventListener("abort", () => this.listeners.delete(listener));
    listener(null);
  }
}
