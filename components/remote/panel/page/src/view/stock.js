// The picture of stock, of the tool that a simulation moves, and of rapid moves that cut.

import {
  BufferAttribute, BufferGeometry, CylinderGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, SphereGeometry,
} from "../../vendor/three.module.min.js";

/** Direction of the light, of length 1. */
const LIGHT = [-0.42, -0.56, 0.714];
/** Brightness of what the light does not reach. */
const SHADE = 0.4;
/** Most rapid moves that are drawn. */
const MAX_RAPIDS = 1000;
/** Length of the tool that a simulation moves, in its radius. */
const TOOL_LENGTH = 8;

/** The picture of a field of heights. It is drawn again where the field has changed. */
export class StockPicture {
  constructor(field, frame, colours) {
    this.field = field;
    // What is uncut, cut, and cut by rapid moves.
    this.colours = [colours.stock, colours.cut, colours.crash].map((c) => [16, 8, 0].map((shift) => ((c >> shift) & 255) / 255));
    const [w, h] = [field.nx + 2, field.ny + 2];
    this.width = w;
    this.positions = new BufferAttribute(new Float32Array(3 * w * h), 3);
    this.shades = new BufferAttribute(new Float32Array(3 * w * h), 3);
    const faces = new Uint32Array(6 * (w - 1) * (h - 1) + 6);
    let at = 0;
    for (let j = 0; j + 1 < h; j++) {
      for (let i = 0; i + 1 < w; i++) {
        const a = j * w + i;
        faces.set([a, a + 1, a + w, a + 1, a + w + 1, a + w], at);
        at += 6;
      }
    }
    // The underside.
    const last = (h - 1) * w;
    faces.set([0, last, w - 1, w - 1, last, last + w - 1], at);
    const geometry = new BufferGeometry().setAttribute("position", this.positions).setAttribute("color", this.shades);
    geometry.setIndex(new BufferAttribute(faces, 1));
    this.mesh = new Mesh(geometry, new MeshBasicMaterial({ vertexColors: true, side: DoubleSide }));
    this.mesh.frustumCulled = false;
    this.node = new Group();
    this.node.add(this.mesh);
    this.node.position.set(...frame.zero);
    this.node.rotation.z = frame.angle;
    field.changed = [0, field.ny - 1];
    this.draw();
  }

  /** Takes over the rows that have changed. */
  draw() {
    const { field, width } = this;
    const [first, last] = field.changed;
    if (first > last) return;
    // Neighbours of a row have other slopes; the rows outside of the field are its walls.
    const from = first <= 1 ? 0 : first;
    const to = last >= field.ny - 2 ? field.ny + 1 : last + 2;
    for (let j = from; j <= to; j++) for (let i = 0; i < width; i++) this.vertex(i, j);
    this.positions.needsUpdate = true;
    this.shades.needsUpdate = true;
    field.settled();
  }

  vertex(i, j) {
    const { field } = this;
    const { nx, ny, dx, dy, low, high, heights } = field;
    const [column, row] = [Math.min(nx, Math.max(1, i)) - 1, Math.min(ny, Math.max(1, j)) - 1];
    const isWall = i === 0 || j === 0 || i === nx + 1 || j === ny + 1;
    const at = row * nx + column;
    const along = (k, n, a, b, d) => (k <= 1 ? a : k >= n ? b : a + (k - 0.5) * d);
    const place = j * this.width + i;
    this.positions.setXYZ(place, along(i, nx, low[0], high[0], dx), along(j, ny, low[1], high[1], dy), isWall ? low[2] : heights[at]);
    let light = SHADE;
    if (!isWall) {
      const [left, right] = [Math.max(0, column - 1), Math.min(nx - 1, column + 1)];
      const [near, far] = [Math.max(0, row - 1), Math.min(ny - 1, row + 1)];
      const slopeX = (heights[row * nx + right] - heights[row * nx + left]) / (Math.max(1, right - left) * dx);
      const slopeY = (heights[far * nx + column] - heights[near * nx + column]) / (Math.max(1, far - near) * dy);
      const reflects = (LIGHT[2] - slopeX * LIGHT[0] - slopeY * LIGHT[1]) / Math.sqrt(1 + slopeX * slopeX + slopeY * slopeY);
      light += (1 - SHADE) * Math.max(0, reflects);
    }
    const [r, g, b] = this.colours[field.marks[at]];
    this.shades.setXYZ(place, r * light, g * light, b * light);
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

/** The tool of a simulation in its own size, with another colour than that of the machine. */
export class Cutter {
  constructor(colour) {
    const material = new MeshLambertMaterial({ color: colour, transparent: true, opacity: 0.8 });
    this.shank = new Mesh(new CylinderGeometry(1, 1, 1, 24), material);
    this.shank.rotation.x = Math.PI / 2;
    this.end = new Mesh(new SphereGeometry(1, 24, 12), material);
    this.node = new Group();
    this.node.add(this.shank, this.end);
  }

  /** Places the tip. */
  move([x, y, z], { radius, isBall }) {
    const from = isBall ? radius : 0;
    const long = TOOL_LENGTH * radius - from;
    this.shank.scale.set(radius, long, radius);
    this.shank.position.z = from + long / 2;
    this.end.visible = isBall;
    this.end.scale.setScalar(radius);
    this.end.position.z = radius;
    this.node.position.set(x, y, z);
  }
}

/** Rapid moves that have cut: they are seen through the stock. */
export class Crashes {
  constructor(colour) {
    this.points = new BufferAttribute(new Float32Array(6 * MAX_RAPIDS), 3);
    this.node = new LineSegments(new BufferGeometry().setAttribute("position", this.points), new LineBasicMaterial({ color: colour, depthTest: false }));
    this.node.renderOrder = 1;
    this.node.frustumCulled = false;
    this.show([], null);
  }

  /** Shows the moves that end at these points of a path. */
  show(ends, path) {
    const count = Math.min(MAX_RAPIDS, ends.length);
    if (count < this.count) this.count = 0;
    for (let n = this.count ?? 0; n < count; n++) {
      this.points.setXYZ(2 * n, ...path.tip(ends[n] - 1, ends[n]));
      this.points.setXYZ(2 * n + 1, ...path.tip(ends[n]));
      this.points.needsUpdate = true;
    }
    this.count = count;
    this.node.geometry.setDrawRange(0, 2 * count);
  }
}
