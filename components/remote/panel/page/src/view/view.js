// The picture of the machine: lines of path, limits and zeros below, tool and machine above.
//
// A large path is drawn in parts, one in each picture, so that the page answers in between; while the camera moves, a
// coarse picture stands for it.

import { Box3, Matrix4, OrthographicCamera, Scene, Vector3, WebGLRenderer } from "../../vendor/three.module.min.js";
import { OrbitControls } from "../../vendor/OrbitControls.js";
import { pathLines } from "./path.js";
import { Lines, Raster } from "./raster.js";

const DIRECTIONS = {
  iso: [-1, -1.4, 1.1], top: [0, -1e-4, 1], front: [0, -1, 0], side: [1, 0, 0],
};
/** Colours of X, Y and Z. */
const AXIS_COLOURS = [0xff3030, 0x30c030, 0x4080ff];
/** Kinds of lines of two passes, first all but rapids, then rapids: they show what is behind them. */
const PASSES = [[false, false, true, true, true], [false, true, false, false, false]];
/** Time for lines in one picture. */
const PART_MS = 40;
/** Lines between two looks at the time. */
const LOOK = 8192;
/** Number of lines of the coarse picture. */
const COARSE = 60_000;

/** The picture of a path and a machine. */
export class View {
  constructor(host, colours) {
    this.host = host;
    this.colours = colours;
    this.live = new Scene();
    this.camera = new OrthographicCamera(-1, 1, 1, -1, -1e5, 1e5);
    this.camera.up.set(0, 0, 1);
    this.below = document.createElement("canvas");
    this.below.classList.add("layer");
    host.append(this.below);
    this.above = new WebGLRenderer({ antialias: !isSoftware(), alpha: true });
    this.above.domElement.classList.add("layer");
    host.append(this.above.domElement);
    this.controls = new OrbitControls(this.camera, this.above.domElement);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => this.moved());
    this.controls.addEventListener("end", () => this.refine());
    this.limits = new Lines();
    this.zeros = new Lines();
    /** Lines of the paths, the ones behind first. */
    this.layers = [];
    this.raster = null;
    this.box = new Box3(new Vector3(-50, -50, 0), new Vector3(50, 50, 50));
    [this.step, this.at] = [0, 0];
    this.frame = null;
    this.isCoarse = false;
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(host);
    this.look("iso");
  }

  /** Frees what the browser holds for the picture. */
  dispose() {
    cancelAnimationFrame(this.frame);
    clearTimeout(this.timer);
    this.sizes.disconnect();
    this.controls.dispose();
    this.above.dispose();
    this.above.forceContextLoss();
    this.above.domElement.remove();
    this.below.remove();
  }

  resize() {
    const [w, h] = [this.host.clientWidth, this.host.clientHeight];
    if (w === 0 || h === 0) return;
    const ratio = Math.min(2, devicePixelRatio);
    this.above.setPixelRatio(ratio);
    this.above.setSize(w, h, false);
    this.below.width = Math.floor(w * ratio);
    this.below.height = Math.floor(h * ratio);
    this.raster = new Raster(this.below.width, this.below.height);
    this.frustum();
    this.refine();
  }

  frustum() {
    const [w, h] = [this.host.clientWidth || 1, this.host.clientHeight || 1];
    const r = 0.55 * Math.max(1e-3, this.box.getSize(new Vector3()).length());
    const k = Math.max(1, w / h);
    const m = Math.max(1, h / w);
    Object.assign(this.camera, { left: -r * k, right: r * k, top: r * m, bottom: -r * m });
    this.camera.updateProjectionMatrix();
  }

  /** Looks from a direction at the whole. */
  look(name) {
    const centre = this.box.getCenter(new Vector3());
    const far = Math.max(1, this.box.getSize(new Vector3()).length());
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(new Vector3(...DIRECTIONS[name]).normalize(), far);
    this.camera.near = -10 * far;
    this.camera.far = 10 * far;
    this.camera.zoom = 1;
    this.frustum();
    this.controls.update();
    this.refine();
  }

  /** Zooms by a factor. */
  zoom(factor) {
    this.camera.zoom *= factor;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.refine();
  }

  /** Shows the travel limits; `low` and `high` are points. */
  setLimits(low, high) {
    this.machineBox = new Box3(new Vector3(...low), new Vector3(...high));
    this.limits = new Lines();
    const { limit, grid } = this.colours;
    const corner = (bits) => [0, 1, 2].map((axis) => ((bits >> axis) & 1 ? high : low)[axis]);
    for (const bits of [0, 1, 2, 3, 4, 5, 6, 7]) {
      for (const bit of [1, 2, 4]) if (!(bits & bit)) this.limits.add(corner(bits), corner(bits | bit), limit);
    }
    const step = Math.max(high[0] - low[0], high[1] - low[1]) / 10;
    for (let x = low[0] + step; x < high[0] - step / 2; x += step) this.limits.add([x, low[1], low[2]], [x, high[1], low[2]], grid);
    for (let y = low[1] + step; y < high[1] - step / 2; y += step) this.limits.add([low[0], y, low[2]], [high[0], y, low[2]], grid);
    this.fit();
  }

  /** Takes the space that a machine without limits may need. */
  setReach(low, high) {
    this.machineBox = new Box3(new Vector3(...low), new Vector3(...high));
    this.fit();
  }

  /** Shows the zeros of coordinate systems. */
  setZeros(points) {
    const size = 0.06 * this.box.getSize(new Vector3()).length();
    this.zeros = new Lines();
    for (const { point, angle, isCurrent } of points) {
      AXIS_COLOURS.forEach((colour, axis) => {
        const end = new Vector3().setComponent(axis, isCurrent ? size : size / 2).applyAxisAngle(new Vector3(0, 0, 1), angle);
        this.zeros.add(point, end.add(new Vector3(...point)).toArray(), colour);
      });
    }
    this.refine();
  }

  /** Shows a path, or none; with a planned one, that one, and the other faintly behind it. */
  setPath(path, options, planned = null) {
    this.pathBox = path?.count > 1 ? new Box3(new Vector3(...path.low), new Vector3(...path.high)) : null;
    this.setLayers(path, options, planned);
    this.fit();
  }

  /** Shows the same path otherwise, from where it is looked at now. */
  setLayers(path, options, planned = null) {
    this.layers = [];
    if (!this.pathBox) return;
    if (planned) this.layers.push(pathLines(path, { ...options, faint: this.colours.limit }));
    this.layers.push(pathLines(planned ?? path, options));
    this.refine();
  }

  /** Fits what is shown: the path, or the machine where there is none. */
  fit(whole = false) {
    const box = whole || !this.pathBox ? this.machineBox : this.pathBox;
    if (box && !box.isEmpty()) this.box = box.clone().expandByScalar(0.02 * box.getSize(new Vector3()).length() + 1e-6);
    this.look("iso");
  }

  moved() {
    this.isCoarse = true;
    this.request();
  }

  /** Draws everything again, in parts. */
  refine() {
    [this.step, this.at] = [0, 0];
    this.isCoarse = false;
    this.mustClear = true;
    this.request();
  }

  /** Draws the next picture soon. */
  request() {
    this.frame ??= requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.frame = null;
    if (!this.raster || this.host.clientWidth === 0) return;
    this.drawBelow();
    this.above.render(this.live, this.camera);
  }

  drawBelow() {
    const steps = this.layers.flatMap((lines) => PASSES.map((kinds) => ({ lines, kinds, count: lines.kinds.length })));
    if (this.isCoarse) {
      this.begin();
      for (const { lines, kinds, count } of steps) this.raster.draw(lines, kinds, 0, count, Math.ceil(count / COARSE));
      this.show();
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.refine(), 150);
      return;
    }
    if (!this.mustClear && this.step >= steps.length) return;
    if (this.mustClear) this.begin();
    this.mustClear = false;
    const end = performance.now() + PART_MS;
    while (this.step < steps.length && performance.now() < end) {
      const { lines, kinds, count } = steps[this.step];
      this.at = this.raster.draw(lines, kinds, this.at, Math.min(count, this.at + LOOK));
      if (this.at >= count) [this.step, this.at] = [this.step + 1, 0];
    }
    this.show();
    if (this.step < steps.length) this.request();
    else this.host.dispatchEvent(new CustomEvent("complete"));
  }

  /** Begins a picture with what is not the path. */
  begin() {
    const { camera, raster } = this;
    camera.updateMatrixWorld();
    raster.look(new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).elements);
    raster.clear();
    for (const lines of [this.limits, this.zeros]) {
      for (const kinds of PASSES) raster.draw(lines, kinds, 0, lines.kinds.length);
    }
  }

  /** Shows the lines as far as they are drawn. */
  show() {
    const { pixels, width, height } = this.raster;
    const image = new ImageData(new Uint8ClampedArray(pixels.buffer), width, height);
    this.below.getContext("2d").putImageData(image, 0, 0);
  }
}

/** Returns whether the processor itself draws: smooth edges would cost it four times the work. */
function isSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
