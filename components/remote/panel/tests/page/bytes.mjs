// Paths as the server sends them, for scripts that need one.

/**
 * Returns the bytes of a path. A point has `at`, `kind`, and perhaps `tool`, `feed`, `further` (A B C U V W) and `joints`; a change is
 * the number of a point and the offset of the tool from there on.
 */
export function bytes(points, { flags = 1, changes = [] } = {}) {
  const n = points.length;
  const [further, joints] = ["further", "joints"].map((name) => points.some((point) => point[name]));
  const blocks = [...(further ? ["further"] : []), ...(joints ? ["joints"] : [])];
  const isLong = blocks.length + changes.length > 0;
  const end = isLong ? 4 * Math.ceil((64 + 23 * n) / 4) : 64 + 23 * n;
  const view = new DataView(new ArrayBuffer(end + 24 * n * blocks.length + 16 * changes.length));
  let moves = 0;
  points.forEach((point) => point.further?.forEach((v, k) => { moves |= v === (points[0].further?.[k] ?? 0) ? 0 : 1 << k; }));
  [..."FERPATH1"].forEach((c, i) => view.setUint8(i, c.charCodeAt(0)));
  view.setUint32(8, n, true);
  view.setUint32(12, flags | (moves << 2) | (further ? 1 << 8 : 0) | (joints ? 1 << 9 : 0), true);
  points.forEach(({ at, kind, tool = 1, feed = 600 }, i) => {
    at.forEach((v, axis) => view.setFloat32(64 + 12 * i + 4 * axis, v, true));
    view.setFloat32(64 + 16 * n + 4 * i, kind === 1 ? 0 : feed, true);
    view.setUint16(64 + 20 * n + 2 * i, tool, true);
    view.setUint8(64 + 22 * n + i, kind);
  });
  blocks.forEach((name, block) => points.forEach((point, i) => {
    for (let k = 0; k < 6; k++) view.setFloat32(end + 24 * (n * block + i) + 4 * k, point[name]?.[k] ?? 0, true);
  }));
  changes.forEach(([first, ...offset], i) => {
    const place = end + 24 * n * blocks.length + 16 * i;
    view.setUint32(place, first, true);
    offset.forEach((v, axis) => view.setFloat32(place + 4 + 4 * axis, v, true));
  });
  return view.buffer;
}
