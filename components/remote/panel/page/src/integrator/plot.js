// The waveforms of the scope: a plot with two cursors, by mouse, finger or keyboard.

import uPlot from "../../vendor/uPlot.js";

const COLOURS = ["#3fb1ff", "#ffb020", "#7ed957", "#ff6b8b", "#c78bff", "#4fd6c8", "#f58fd0", "#d9d957"];
const CURSORS = ["#ffb020", "#c78bff"];
const HEIGHT_PX = 320;
/** Part of the width by which a key moves a cursor. */
const KEY_STEP = 0.01;

/** A plot in an element. `moved` is called after a cursor has changed. */
export class Plot {
  constructor(host, t, moved) {
    this.host = host;
    this.t = t;
    this.moved = moved;
    this.cursors = [null, null];
    this.plot = null;
    this.sizes = new ResizeObserver(() => this.plot?.setSize({ width: host.clientWidth, height: HEIGHT_PX }));
    this.sizes.observe(host);
    host.addEventListener("keydown", (event) => this.key(event));
  }

  /** Returns the names of the waveforms. */
  get names() {
    return this.plot?.series.slice(1).map((series) => series.label) ?? [];
  }

  /** Begins anew with these waveforms. */
  open(names) {
    this.plot?.destroy();
    this.cursors.fill(null);
    const css = getComputedStyle(document.body);
    const [text, line] = [css.getPropertyValue("--text"), css.getPropertyValue("--line")];
    const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line } };
    this.plot = new uPlot({
      width: this.host.clientWidth || 600, height: HEIGHT_PX, scales: { x: { time: false } },
      axes: [{ ...axis, label: this.t("scope.time") }, axis],
      series: [{ label: "s" }, ...names.map((label, i) => ({ label, stroke: COLOURS[i % COLOURS.length], width: 1.5, points: { show: false } }))],
      hooks: { draw: [(u) => this.drawCursors(u)] },
      cursor: { drag: { x: true, y: false } },
    }, [[], ...names.map(() => [])], this.host);
    this.plot.over.addEventListener("click", (event) => {
      const left = event.clientX - this.plot.over.getBoundingClientRect().left;
      this.set(event.shiftKey ? 1 : 0, this.plot.posToVal(left, "x"));
    });
    this.plot.over.addEventListener("dblclick", () => this.clear());
  }

  show(data) {
    this.plot?.setData(data);
  }

  set(cursor, x) {
    this.cursors[cursor] = x;
    this.plot.redraw();
    this.moved();
  }

  clear() {
    this.cursors.fill(null);
    this.plot?.redraw();
    this.moved();
  }

  key(event) {
    const { min, max } = this.plot?.scales.x ?? {};
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === "Delete") this.clear();
    else if (step && Number.isFinite(min) && Number.isFinite(max)) {
      const cursor = event.shiftKey ? 1 : 0;
      const from = this.cursors[cursor] ?? (min + max) / 2;
      this.set(cursor, Math.max(min, Math.min(max, from + step * KEY_STEP * (max - min))));
    } else return;
    event.preventDefault();
  }

  drawCursors(u) {
    this.cursors.forEach((x, i) => {
      if (x === null) return;
      const at = Math.round(u.valToPos(x, "x", true));
      u.ctx.save();
      u.ctx.strokeStyle = CURSORS[i];
      u.ctx.setLineDash([6, 4]);
      u.ctx.strokeRect(at, u.bbox.top, 0, u.bbox.height);
      u.ctx.restore();
    });
  }

  close() {
    this.sizes.disconnect();
    this.plot?.destroy();
  }
}
