// Faces of columns that tilted tools have cut below, as blocks, without anything of the browser.

/** Faces of a column's side: step to the neighbour, normal, and the corners of the side, counter-clockwise from outside. */
const SIDES = [
  { step: [1, 0], normal: [1, 0, 0], corners: [[1, 0], [1, 1]] },
  { step: [-1, 0], normal: [-1, 0, 0], corners: [[0, 1], [0, 0]] },
  { step: [0, 1], normal: [0, 1, 0], corners: [[1, 1], [0, 1]] },
  { step: [0, -1], normal: [0, -1, 0], corners: [[0, 0], [1, 0]] },
];

/** Returns which columns are drawn as blocks: those that are split, and their neighbours, with which a smooth surface would close what is open. */
export function blockZone({ nx, ny, split }) {
  const zone = new Uint8Array(nx * ny);
  for (const at of split.keys()) {
    const [column, row] = [at % nx, Math.floor(at / nx)];
    for (let j = Math.max(0, row - 1); j <= Math.min(ny - 1, row + 1); j++) {
      for (let i = Math.max(0, column - 1); i <= Math.min(nx - 1, column + 1); i++) zone[j * nx + i] = 1;
    }
  }
  return zone;
}

/**
 * Returns the faces of the columns of a zone: three coordinates of each corner, four corners to a face, and for each face its
 * normal and the column that it belongs to.
 */
export function blockFaces(field, zone) {
  const { nx, ny, dx, dy, low } = field;
  const faces = { corners: [], normals: [], columns: [] };
  const add = (normal, at, ...corners) => {
    for (const corner of corners) faces.corners.push(...corner);
    faces.normals.push(normal);
    faces.columns.push(at);
  };
  for (let at = 0; at < zone.length; at++) {
    if (zone[at] === 0) continue;
    const [column, row] = [at % nx, Math.floor(at / nx)];
    const [x, y] = [low[0] + column * dx, low[1] + row * dy];
    const pieces = field.pieces(at);
    const corner = ([i, j], z) => [x + i * dx, y + j * dy, z];
    for (let n = 0; n < pieces.length; n += 2) {
      const [bottom, top] = [pieces[n], pieces[n + 1]];
      add([0, 0, 1], at, corner([0, 0], top), corner([1, 0], top), corner([1, 1], top), corner([0, 1], top));
      add([0, 0, -1], at, corner([0, 1], bottom), corner([1, 1], bottom), corner([1, 0], bottom), corner([0, 0], bottom));
      for (const { step: [i, j], normal, corners: [a, b] } of SIDES) {
        const isInside = column + i >= 0 && column + i < nx && row + j >= 0 && row + j < ny;
        const beside = isInside ? field.pieces(at + j * nx + i) : [];
        for (const [from, to] of without(bottom, top, beside)) add(normal, at, corner(a, from), corner(b, from), corner(b, to), corner(a, to));
      }
    }
  }
  return faces;
}

/** Returns what is left of a piece beside others. */
function without(bottom, top, others) {
  const left = [];
  let from = bottom;
  for (let n = 0; n < others.length && from < top; n += 2) {
    if (others[n] > from) left.push([from, Math.min(top, others[n])]);
    from = Math.max(from, others[n + 1]);
  }
  if (from < top) left.push([from, top]);
  return left;
}
