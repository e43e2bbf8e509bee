// The picture of the machine: two canvases, the path below, tool and machine above.
//
// A large path is drawn in parts, one in each picture, so that a slow processor still answers; while the camera moves, a
// coarse picture stands for it.

import {
  AxesHelper, Box3, Box3Helper, Color, GridHelper, Group, OrthographicCamera, Scene, Vector3, WebGLRenderer,
} from "../../vendor/three.module.min.js";
import { OrbitControls } from "../../vendor/OrbitControls.js";
import { PathLines } from "./path.js";

const DIRECTIONS = {
  iso: [-1, -1.4, 1.1], top: [0, -1e-4, 1], front: [0, -1, 0], side: [1, 0, 0],
};

/** The picture of a path and a machine. */
export class View {
  constructor(host, colours) {
    this.host = host;
    this.colours = colours;
    this.scene = new Scene();
    this.live = new Scene();
    this.camera = new OrthographicCamera(-1, 1, 1, -1, -1e5, 1e5);
    this.camera.up.set(0, 0, 1);
    const smooth = !isSoftware();
    this.below = renderer(host, { preserveDrawingBuffer: true, antialias: smooth, alpha: true });
    this.above = renderer(host, { antialias: smooth, alpha: true });
    this.below.autoClear = false;
    this.controls = new OrbitControls(this.camera, this.above.domElement);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => this.moved());
    this.controls.addEventListener("end", () => this.refine());
    this.limits = new Group();
    this.zeros = new Group();
    this.lines = new Group();
    this.scene.add(this.limits, this.zeros, this.lines);
    this.path = null;
    this.box = new Box3(new Vector3(-50, -50, 0), new Vector3(50, 50, 50));
    this.at = 0;
    this.frame = null;
    this.isCoarse = false;
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(host);
    this.look("iso");
  }

  /** Frees what the browser holds for the picture. */
  dispose() {
    cancelAnimationFrame(this.frame);
    this.sizes.disconnect();
    this.controls.dispose();
    this.path?.dispose();
    for (const r of [this.below, this.above]) {
      r.dispose();
      r.forceContextLoss();
      r.domElement.remove();
    }
  }

  resize() {
    const [w, h] = [this.host.clientWidth, this.host.clientHeight];
    if (w === 0 || h === 0) return;
    for (const r of [this.below, this.above]) {
      r.setPixelRatio(Math.min(2, devicePixelRatio));
      r.setSize(w, h, false);
    }
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
    this.limits.clear();
    this.machineBox = null;
    if (!low) return;
    const box = new Box3(new Vector3(...low), new Vector3(...high));
    this.machineBox = box;
    this.limits.add(new Box3Helper(box, new Color(this.colours.limit)));
    const size = Math.max(high[0] - low[0], high[1] - low[1]);
    const grid = new GridHelper(size, 10, this.colours.grid, this.colours.grid);
    grid.rotation.x = Math.PI / 2;
    grid.position.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]);
    this.limits.add(grid);
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
    this.zeros.clear();
    for (const { point, angle, isCurrent } of points) {
      const axes = new AxesHelper(isCurrent ? size : size / 2);
      axes.position.set(...point);
      axes.rotation.z = angle;
      this.zeros.add(axes);
    }
    this.refine();
  }

  /** Shows a path, or none. */
  setPath(path, options) {
    if (this.path) {
      this.path.dispose();
    }
    this.only([]);
    this.path = null;
    this.pathBox = null;
    if (path && path.count > 1) {
      this.path = new PathLines(path, options);
      this.pathBox = new Box3(new Vector3(...path.low), new Vector3(...path.high));
    }
    this.fit();
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
    this.at = 0;
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
    if (this.host.clientWidth === 0) return;
    this.drawBelow();
    this.above.render(this.live, this.camera);
  }

  drawBelow() {
    const { path, below } = this;
    if (this.isCoarse) {
      this.only(path?.coarse ?? []);
      below.clear();
      below.render(this.scene, this.camera);
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.refine(), 150);
      return;
    }
    const total = path?.count ?? 0;
    if (!this.mustClear && this.at >= total) return;
    if (this.mustClear) below.clear();
    this.limits.visible = this.mustClear;
    this.zeros.visible = this.mustClear;
    this.mustClear = false;
    this.only(path && this.at < total ? path.part(this.at) : []);
    below.render(this.scene, this.camera);
    this.at += 1;
    this.limits.visible = true;
    this.zeros.visible = true;
    if (this.at < total) this.request();
    else this.host.dispatchEvent(new CustomEvent("complete"));
  }

  /** Lets the next picture have these lines of the path alone. */
  only(list) {
    this.lines.clear();
    if (list.length > 0) this.lines.add(...list);
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

function renderer(host, options) {
  const made = new WebGLRenderer(options);
  made.domElement.classList.add("layer");
  host.append(made.domElement);
  return made;
}
