// The camera's picture: marks found in it, marks that are expected, and the part's path laid over it.

import { card, el, field, setText } from "../dom.js";
import { RETRY_MS, pause, programPath, request } from "../http.js";
import { Path } from "../view/path.js";

/** Distance in mm within which points of the path are left out. */
const TOLERANCE = 0.005;
/** Begin of the name of a program that stands in the machine's coordinates already. */
const ALIGNED = "aligned-";
/** Kind of a rapid in a path. */
const RAPID = 1;
const COLOURS = { found: "#35e07f", other: "#ffb020", expected: "#3fb1ff", path: "#ff5fa2", rapid: "#c78bff", middle: "#ffffff" };

/** Makes the card. */
export function cameraCard(ctx) {
  const { store, t, prefs, signal } = ctx;
  const canvas = el("canvas", { class: "camera", width: 640, height: 480, role: "img", "aria-label": t("camera.label") });
  const holder = el("div", { class: "scroll camera-holder", tabIndex: 0, role: "region", "aria-label": t("camera.label") }, canvas);
  const state = el("p", { class: "note", id: "camera-state" });
  const zoom = el("select", { id: "camera-zoom", onchange: draw }, ...[1, 2, 4, 8].map((n) => el("option", { value: String(n) }, `${n} ×`)));
  const light = el("input", { type: "range", id: "camera-light", min: "0.3", max: "3", step: "0.1", value: "1", oninput: draw });
  const laid = el("select", { id: "camera-path", onchange: () => prefs.set("laid", laid.value) },
    ...["auto", "placed", "machine", "none"].map((how) => el("option", { value: how }, t(`camera.path.${how}`))));
  laid.value = prefs.get("laid");
  const canvas2d = canvas.getContext("2d");
  let view = null;
  let bitmap = null;
  let path = null;

  /** Takes one picture after the other; a slow viewer takes fewer. */
  async function watch() {
    while (!signal.aborted) {
      if (document.hidden) {
        await pause(RETRY_MS);
        continue;
      }
      try {
        const response = await request("GET", view ? `/align/picture?after=${view.number}` : "/align/picture", { signal });
        const header = response.headers.get("X-Ferrule-View");
        canvas.classList.toggle("stale", response.status === 204);
        if (response.status === 204) {
          // The camera has no picture, or none has come yet.
          if (header) setText(state, JSON.parse(decodeURIComponent(header)).problem);
          await pause(RETRY_MS);
          continue;
        }
        const told = JSON.parse(decodeURIComponent(header));
        const next = await createImageBitmap(await response.blob());
        bitmap?.close();
        [view, bitmap] = [told, next];
        draw();
      } catch (error) {
        if (signal.aborted) return;
        canvas.classList.add("stale");
        setText(state, error.message);
        await pause(RETRY_MS);
      }
    }
  }

  function draw() {
    canvas.style.width = `${100 * Number(zoom.value)}%`;
    if (!bitmap) return;
    if (canvas.width !== view.width || canvas.height !== view.height) Object.assign(canvas, { width: view.width, height: view.height });
    canvas2d.filter = `brightness(${light.value})`;
    canvas2d.drawImage(bitmap, 0, 0);
    canvas2d.filter = "none";
    const align = store.get("align");
    drawPath(align);
    drawExpected(align);
    stroke(cross(view.width / 2, view.height / 2, 14), COLOURS.middle, 2);
    for (const mark of view.marks) drawFound(mark);
    describe();
  }

  /** Strokes a figure with a dark edge, so that it is seen on any picture. */
  function stroke(figure, colour, width, dash = []) {
    canvas2d.setLineDash(dash);
    for (const [style, extra] of [["#000000a0", 2], [colour, 0]]) {
      canvas2d.strokeStyle = style;
      canvas2d.lineWidth = width + extra;
      canvas2d.stroke(figure);
    }
    canvas2d.setLineDash([]);
  }

  function label(text, x, y, colour) {
    canvas2d.font = "600 14px system-ui, sans-serif";
    canvas2d.lineWidth = 4;
    canvas2d.strokeStyle = "#000000c0";
    canvas2d.strokeText(text, x, y);
    canvas2d.fillStyle = colour;
    canvas2d.fillText(text, x, y);
  }

  function drawPath({ place }) {
    const isPlaced = howLaid() === "placed";
    if (!path || howLaid() === "none" || !view.to_picture || (isPlaced && !place)) return;
    const over = isPlaced ? matrix(view.to_picture).multiply(matrix(place)) : matrix(view.to_picture);
    for (const [figure, colour, width, dash] of [[path.rapids, COLOURS.rapid, 2, [4, 6]], [path.cuts, COLOURS.path, 3, []]]) {
      const shown = new Path2D();
      shown.addPath(figure, over);
      stroke(shown, colour, width, dash);
    }
  }

  function drawExpected(align) {
    if (!view.to_picture) return;
    const over = matrix(view.to_picture);
    const scale = Math.sqrt(Math.abs(over.a * over.d - over.b * over.c));
    (align.marks ?? []).forEach((mark, i) => {
      if (!mark.expected) return;
      const { x, y } = over.transformPoint(new DOMPoint(...mark.expected));
      const radius = (scale * align.size) / 2 + 6;
      if (x < -radius || y < -radius || x > view.width + radius || y > view.height + radius) return;
      const figure = new Path2D();
      figure.arc(x, y, radius, 0, 2 * Math.PI);
      stroke(figure, COLOURS.expected, 2, [6, 5]);
      label(t("camera.mark", i + 1), x + radius * 0.72, y - radius * 0.72, COLOURS.expected);
    });
  }

  function drawFound(mark) {
    const { x, y, size, angle, kind } = mark;
    const colour = mark.is_chosen ? COLOURS.found : COLOURS.other;
    const figure = new Path2D();
    if (kind === "square") {
      const turn = new DOMMatrix().translateSelf(x, y).rotateSelf(angle);
      const square = new Path2D();
      square.rect(-size / 2, -size / 2, size, size);
      figure.addPath(square, turn);
    } else figure.arc(x, y, size / 2, 0, 2 * Math.PI);
    stroke(figure, colour, 3);
    stroke(cross(x, y, 8), colour, 2);
    label(`± ${mark.uncertainty.toFixed(3)} px`, x + 12, y + 24, colour);
  }

  function describe() {
    const chosen = view.marks.find((mark) => mark.is_chosen);
    const at = t("camera.at", view.at[0].toFixed(3), view.at[1].toFixed(3));
    const seen = chosen ? t("camera.found", t(`camera.${chosen.kind}`), chosen.x.toFixed(2), chosen.y.toFixed(2), chosen.uncertainty.toFixed(3)) : view.problem ?? "";
    setText(state, `${at} ${seen}`);
    canvas.dataset.number = String(view.number);
    canvas.dataset.marks = String(view.marks.length);
    canvas.setAttribute("aria-label", `${t("camera.label")}: ${seen}`);
  }

  const howLaid = () => {
    if (laid.value !== "auto") return laid.value;
    return (store.get("program").name ?? "").split("/").at(-1).startsWith(ALIGNED) ? "machine" : "placed";
  };

  let loaded = 0;
  async function load(name, version) {
    path = null;
    if (!name) return draw();
    try {
      const response = await request("GET", `${programPath(name, "/path")}?tolerance=${ctx.mm.read(TOLERANCE)}`, { signal });
      const read = figures(new Path(await response.arrayBuffer()), ctx.mm);
      if (loaded === version) path = read;
    } catch (error) {
      if (error.name !== "AbortError") ctx.fail(error);
    }
    draw();
  }
  store.listen(() => {
    const { name, lines, version } = store.get("program");
    const isRead = Boolean(name && lines);
    const next = isRead ? version : 0;
    if (next === loaded) return;
    loaded = next;
    load(isRead ? name : null, next);
  }, signal);
  prefs.listen(draw, signal);
  signal.addEventListener("abort", () => bitmap?.close());
  watch();
  const legend = el("p", { class: "note" }, t("camera.legend"));
  return card("camera", t("camera"),
    el("div", { class: "row" }, field(t("camera.zoom"), zoom), field(t("camera.light"), light), field(t("camera.path"), laid)), holder, state, legend);
}

/** Returns a map whose numbers come row by row, then the shift. */
const matrix = ([a, c, b, d, e, f]) => new DOMMatrix([a, b, c, d, e, f]);

function cross(x, y, size) {
  const figure = new Path2D();
  figure.moveTo(x - size, y);
  figure.lineTo(x + size, y);
  figure.moveTo(x, y - size);
  figure.lineTo(x, y + size);
  return figure;
}

/** Returns the cuts and the rapids of a path in machine units as figures in millimetres. */
export function figures({ count, points, origin, kinds }, mm) {
  const [cuts, rapids] = [new Path2D(), new Path2D()];
  const at = (i) => [0, 1].map((axis) => mm.show(points[3 * i + axis] + origin[axis]));
  let last = null;
  for (let i = 1; i < count; i++) {
    if (kinds[i] === 0) {
      last = null;
      continue;
    }
    const figure = kinds[i] === RAPID ? rapids : cuts;
    if (figure !== last) figure.moveTo(...at(i - 1));
    figure.lineTo(...at(i));
    last = figure;
  }
  return { cuts, rapids };
}
