// Faces of columns that tilted tools have cut below, as blocks, without anything of the browser.

/** Normals of faces: up, down, and those of a column's sides. */
export const NORMALS = [[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]];
/** Faces of a column's side: number of the normal, step to the neighbour, and the corners of the side, counter-clockwise from outside. */
const SIDES = [
  { normal: 2, step: [1, 0], corners: [[1, 0], [1, 1]] },
  { normal: 3, step: [-1, 0], corners: [[0, 1], [0, 0]] },
  { normal: 4, step: [0, 1], corners: [[1, 1], [0, 1]] },
  { normal: 5, step: [0, -1], corners: [[0, 0], [1, 0]] },
];

/** Returns whether a column is drawn as blocks: one that is split, and its neighbours, with which a smooth surface would close what is open. */
export function isBlock({ nx, ny, isSplit }, column, row) {
  for (let j = Math.max(0, row - 1); j <= Math.min(ny - 1, row + 1); j++) {
    for (let i = Math.max(0, column - 1); i <= Math.min(nx - 1, column + 1); i++) if (isSplit[j * nx + i] !== 0) return true;
  }
  return false;
}

/** Faces that grow: three coordinates of each corner, four corners to a face, and for each face the number of its normal and its column. */
class Faces {
  constructor() {
    this.count = 0;
    this.room(1024);
  }

  /** Makes room for a number of faces. */
  room(most) {
    const grown = (type, size, old) => {
      const values = new type(size);
      if (old) values.set(old);
      return values;
    };
    this.corners = grown(Float32Array, 12 * most, this.corners);
    this.normals = grown(Uint8Array, most, this.normals);
    this.columns = grown(Uint32Array, most, this.columns);
  }

  /** Adds a face with the coordinates of its corners. */
  add(normal, at, ...numbers) {
    if (this.count === this.normals.length) this.room(2 * this.count);
    for (let k = 0; k < 12; k++) this.corners[12 * this.count + k] = numbers[k];
    this.normals[this.count] = normal;
    this.columns[this.count] = at;
    this.count += 1;
  }

  /** Returns what there is, and begins anew. */
  take() {
    const { count } = this;
    this.count = 0;
    return { count, corners: this.corners.slice(0, 12 * count), normals: this.normals.slice(0, count), columns: this.columns.slice(0, count) };
  }
}

/** One for all: it keeps its room. */
const faces = new Faces();

/** Returns the faces of the columns of some rows that `isShown` tells: each is counter-clockwise from outside. */
export function blockFaces(field, first, last, isShown = isBlock) {
  for (let row = first; row <= last; row++) {
    for (let column = 0; column < field.nx; column++) if (isShown(field, column, row)) addColumn(field, column, row);
  }
  return faces.take();
}

function addColumn(field, column, row) {
  const { nx, ny, dx, dy, low } = field;
  const at = row * nx + column;
  const [x0, y0] = [low[0] + column * dx, low[1] + row * dy];
  const [x1, y1] = [x0 + dx, y0 + dy];
  const pieces = field.pieces(at);
  for (let n = 0; n < pieces.length; n += 2) {
    const [bottom, top] = [pieces[n], pieces[n + 1]];
    faces.add(0, at, x0, y0, top, x1, y0, top, x1, y1, top, x0, y1, top);
    faces.add(1, at, x0, y1, bottom, x1, y1, bottom, x1, y0, bottom, x0, y0, bottom);
  }
  for (const { normal, step: [i, j], corners: [a, b] } of SIDES) {
    const isInside = column + i >= 0 && column + i < nx && row + j >= 0 && row + j < ny;
    const beside = isInside ? field.pieces(at + j * nx + i) : [];
    const [ax, ay, bx, by] = [a[0] ? x1 : x0, a[1] ? y1 : y0, b[0] ? x1 : x0, b[1] ? y1 : y0];
    const add = (from, to) => faces.add(normal, at, ax, ay, from, bx, by, from, bx, by, to, ax, ay, to);
    for (let n = 0; n < pieces.length; n += 2) without(pieces[n], pieces[n + 1], beside, add);
  }
}

/** Calls `add` with what is left of a piece beside others. */
function without(bottom, top, others, add) {
  let from = bottom;
  for (let n = 0; n < others.length && from < top; n += 2) {
    if (others[n] > from) add(from, Math.min(top, others[n]));
    from = Math.max(from, others[n + 1]);
  }
  if (from < top) add(from, top);
}
