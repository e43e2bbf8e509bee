// The picture of stock, of the tool that a simulation moves, and of rapid moves that cut.

import {
  BufferAttribute, BufferGeometry, CylinderGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, SphereGeometry, Vector3,
} from "../../vendor/three.module.min.js";
import { NORMALS, blockFaces } from "./blocks.js";
import { dot } from "./sweep.js";

/** Direction of the light, of length 1. */
const LIGHT = [-0.42, -0.56, 0.714];
/** Brightness of what the light does not reach. */
const SHADE = 0.4;
const UP = new Vector3(0, 0, 1);
/** Most rapid moves that are drawn. */
const MAX_RAPIDS = 1000;
/** Most bands of rows whose blocks are drawn by themselves. */
const BANDS = 256;
/** Rest after stock was drawn, in the time that this took: the page answers in between. */
const REST = 3;
/** Corners of the two triangles of a face. */
const QUAD = [0, 1, 2, 0, 2, 3];
/** Length of the tool that a simulation moves, in its radius. */
const TOOL_LENGTH = 8;

/** The picture of columns of material. It is drawn again where the field has changed: as a smooth surface, and as blocks where tools have cut below. */
export class StockPicture {
  constructor(field, frame, colours) {
    this.field = field;
    // What is uncut, cut, and cut by rapid moves.
    this.colours = [colours.stock, colours.cut, colours.crash].map((c) => [16, 8, 0].map((shift) => ((c >> shift) & 255) / 255));
    const [w, h] = [field.nx + 2, field.ny + 2];
    this.width = w;
    this.positions = new BufferAttribute(new Float32Array(3 * w * h), 3);
    this.shades = new BufferAttribute(new Float32Array(3 * w * h), 3);
    this.faces = new BufferAttribute(new Uint32Array(6 * (w - 1) * (h - 1) + 6), 1);
    for (let j = 0; j + 1 < h; j++) this.row(j);
    // The underside.
    const last = (h - 1) * w;
    this.faces.array.set([0, last, w - 1, w - 1, last, last + w - 1], 6 * (w - 1) * (h - 1));
    const geometry = new BufferGeometry().setAttribute("position", this.positions).setAttribute("color", this.shades);
    geometry.setIndex(this.faces);
    const material = new MeshBasicMaterial({ vertexColors: true, side: DoubleSide });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.node = new Group();
    this.node.add(this.mesh);
    /** Blocks of each band of rows, where it has any. */
    this.bands = [];
    this.bandRows = Math.ceil(field.ny / BANDS);
    const [a, b, c, d, e, f, g, k, l] = frame.turn;
    this.node.position.set(...frame.zero);
    this.node.quaternion.setFromRotationMatrix(new Matrix4().set(a, b, c, 0, d, e, f, 0, g, k, l, 0, 0, 0, 0, 1));
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
    for (const values of [this.positions, this.shades]) renew(values, 3 * width * from, 3 * width * (to + 1));
    if (field.split.size > 0 || this.bands.some(Boolean)) {
      const [begin, end] = [Math.max(0, from - 1), Math.min(to, field.ny)];
      for (let j = begin; j <= end; j++) this.row(j);
      renew(this.faces, 6 * (width - 1) * begin, 6 * (width - 1) * (end + 1));
      // A row is drawn as the rows beside it are.
      const band = (row) => Math.floor(Math.min(field.ny - 1, Math.max(0, row)) / this.bandRows);
      for (let n = band(first - 1); n <= band(last + 1); n++) this.drawBand(n);
    }
    field.settled();
  }

  /** Joins a row of points with the next, except around columns that are blocks. */
  row(j) {
    const { field: { nx, ny, isSplit }, width: w } = this;
    const at = (i, k) => (Math.min(ny, Math.max(1, k)) - 1) * nx + Math.min(nx, Math.max(1, i)) - 1;
    for (let i = 0; i + 1 < w; i++) {
      const a = j * w + i;
      const isOpen = isSplit[at(i, j)] + isSplit[at(i + 1, j)] + isSplit[at(i, j + 1)] + isSplit[at(i + 1, j + 1)] > 0;
      this.faces.array.set(isOpen ? [a, a, a, a, a, a] : [a, a + 1, a + w, a + 1, a + w + 1, a + w], 6 * (j * (w - 1) + i));
    }
  }

  /** Draws the blocks of a band of rows anew. */
  drawBand(n) {
    const { field, bands, bandRows } = this;
    const { count, corners, normals, columns } = blockFaces(field, n * bandRows, Math.min(field.ny, (n + 1) * bandRows) - 1);
    if (bands[n]) {
      this.node.remove(bands[n]);
      bands[n].geometry.dispose();
      bands[n] = null;
    }
    if (count === 0) return;
    const shades = new Uint8Array(12 * count);
    const index = new Uint32Array(6 * count);
    for (let face = 0; face < count; face++) {
      const light = SHADE + (1 - SHADE) * Math.max(0, dot(NORMALS[normals[face]], LIGHT));
      const colour = this.colours[field.marks[columns[face]]];
      for (let k = 0; k < 12; k++) shades[12 * face + k] = Math.round(255 * light * colour[k % 3]);
      for (let k = 0; k < 6; k++) index[6 * face + k] = 4 * face + QUAD[k];
    }
    const geometry = new BufferGeometry()
      .setAttribute("position", new BufferAttribute(corners, 3))
      .setAttribute("color", new BufferAttribute(shades, 3, true))
      .setIndex(new BufferAttribute(index, 1));
    bands[n] = new Mesh(geometry, this.mesh.material);
    bands[n].frustumCulled = false;
    this.node.add(bands[n]);
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
    for (const band of this.bands) band?.geometry.dispose();
    this.mesh.material.dispose();
  }
}

/** Draws stock unless its picture rests; returns after how many milliseconds what has changed meanwhile is to be drawn, or 0. */
export function drawRested(stock, clock = performance) {
  const begun = clock.now();
  const rest = (stock.restsUntil ?? 0) - begun;
  if (rest > 0) return stock.field.changed[1] >= 0 ? rest : 0;
  stock.picture.draw();
  const ended = clock.now();
  stock.restsUntil = ended + REST * (ended - begun);
  return 0;
}

/** Gives the graphics processor a part of what it has. */
function renew(values, from, to) {
  values.addUpdateRange(from, to - from);
  values.needsUpdate = true;
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

  /** Places the tip; the tool points along an axis, or is upright. */
  move([x, y, z], { radius, isBall }, axis = null) {
    this.node.quaternion.setFromUnitVectors(UP, axis ? new Vector3(...axis) : UP);
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
