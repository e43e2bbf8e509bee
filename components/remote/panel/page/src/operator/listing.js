// The lines of a program, however many: only those that are seen exist as elements.

import { el } from "../dom.js";

const ROW_PX = 20;
/** Browsers limit the height of an element; a longer list scrolls faster than it is tall. */
const MAX_HEIGHT_PX = 8_000_000;
/** The byte between two lines. */
const BREAK = 10;

/** The text of a program as bytes, with the place of each line. */
export class Program {
  constructor(name, buffer) {
    this.name = name;
    this.bytes = new Uint8Array(buffer);
    const starts = lineStarts(this.bytes);
    this.starts = starts;
    const count = starts.length - 1;
    const endsWithBreak = this.bytes.length > 0 && this.bytes.at(-1) === BREAK;
    this.lines = endsWithBreak ? count - 1 : count;
    this.decoder = new TextDecoder();
  }

  /** Returns a line by its number from 1. */
  line(number) {
    return this.decoder.decode(this.bytes.subarray(this.starts[number - 1], this.starts[number] - 1)).trimEnd();
  }
}

/** Returns where each line begins, and where one behind the last would. */
function lineStarts(bytes) {
  let starts = new Uint32Array(1024);
  let count = 1;
  for (let at = bytes.indexOf(BREAK); at >= 0; at = bytes.indexOf(BREAK, at + 1)) {
    if (count + 1 === starts.length) {
      const more = new Uint32Array(2 * starts.length);
      more.set(starts);
      starts = more;
    }
    starts[count++] = at + 1;
  }
  starts[count++] = bytes.length + 1;
  return starts.subarray(0, count);
}

/** A list of the lines of a program that follows the current one. */
export class Listing {
  constructor(t, choose) {
    this.t = t;
    this.program = null;
    this.current = 0;
    this.chosen = 0;
    this.follows = true;
    this.space = el("div", { class: "space" });
    this.rows = el("ol", { class: "rows" });
    this.node = el("div", { class: "listing", tabIndex: 0, role: "region", "aria-label": t("listing") }, this.space, this.rows);
    this.node.addEventListener("scroll", () => this.draw(), { passive: true });
    for (const name of ["wheel", "pointerdown", "keydown"]) {
      this.node.addEventListener(name, () => { this.follows = false; }, { passive: true });
    }
    this.rows.addEventListener("click", (event) => {
      const row = event.target.closest("li");
      if (row) choose(Number(row.value));
    });
    new ResizeObserver(() => this.draw()).observe(this.node);
  }

  /** Shows a program from its start, or none. */
  open(program) {
    this.program = program;
    this.current = 0;
    this.chosen = 0;
    this.follows = true;
    this.node.scrollTop = 0;
    this.space.style.height = `${this.height()}px`;
    this.draw();
  }

  height() {
    return Math.min(MAX_HEIGHT_PX, (this.program?.lines ?? 0) * ROW_PX);
  }

  /** Marks the line in execution; 0 for none. */
  mark(current) {
    if (current === this.current) return;
    if (this.current === 0) this.follows = true;
    this.current = current;
    if (this.follows && current > 0) this.show(current);
    this.draw();
  }

  /** Marks the line that was chosen. */
  choose(line) {
    this.chosen = line;
    this.draw();
  }

  show(line) {
    const seen = this.node.clientHeight;
    const all = (this.program?.lines ?? 0) * ROW_PX;
    if (all <= seen) return;
    const share = Math.max(0, Math.min(1, ((line - 1) * ROW_PX - seen / 2) / (all - seen)));
    this.node.scrollTop = share * (this.height() - seen);
  }

  draw() {
    const { program, node } = this;
    if (!program) {
      this.rows.replaceChildren();
      return;
    }
    const seen = node.clientHeight;
    const all = program.lines * ROW_PX;
    const share = this.height() > seen ? node.scrollTop / (this.height() - seen) : 0;
    const top = Math.min(1, share) * Math.max(0, all - seen);
    const first = Math.floor(top / ROW_PX);
    const count = Math.min(program.lines - first, Math.ceil(seen / ROW_PX) + 1);
    const rows = [];
    for (let i = 0; i < count; i++) rows.push(this.row(first + i + 1));
    this.rows.replaceChildren(...rows);
    this.rows.style.top = `${node.scrollTop - (top - first * ROW_PX)}px`;
  }

  row(number) {
    const names = [number === this.current ? "current" : "", number === this.chosen ? "chosen" : ""].join(" ").trim();
    const row = el("li", { class: names }, el("span", { class: "no" }, String(number)), this.program.line(number));
    row.value = number;
    if (number === this.current) row.setAttribute("aria-current", "step");
    return row;
  }
}
