// Rotations as nine numbers, row by row, and frames: where something is and how it is turned. Without anything of the browser.

export const RADIANS = Math.PI / 180;
export const IDENTITY = [1, 0, 0, 0, 1, 0, 0, 0, 1];

export const plus = (a, b) => a.map((v, i) => v + b[i]);
export const minus = (a, b) => a.map((v, i) => v - b[i]);

/** Returns the rotation about X, Y or Z (0, 1, 2) by an angle in radians. */
export function about(axis, angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  if (axis === 0) return [1, 0, 0, 0, c, -s, 0, s, c];
  if (axis === 1) return [c, 0, s, 0, 1, 0, -s, 0, c];
  return [c, -s, 0, s, c, 0, 0, 0, 1];
}

/** Returns the rotation about a unit vector by an angle in radians (Rodrigues' formula). */
export function aboutVector([x, y, z], angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  const t = 1 - c;
  return [t * x * x + c, t * x * y - s * z, t * x * z + s * y, t * x * y + s * z, t * y * y + c, t * y * z - s * x, t * x * z - s * y, t * y * z + s * x, t * z * z + c];
}

/** Returns one rotation after another: that of the second comes first. */
export function times(a, b) {
  const out = new Array(9);
  for (let i = 0; i < 9; i += 3) {
    for (let j = 0; j < 3; j++) out[i + j] = a[i] * b[j] + a[i + 1] * b[j + 3] + a[i + 2] * b[j + 6];
  }
  return out;
}

export const transposed = ([a, b, c, d, e, f, g, h, i]) => [a, d, g, b, e, h, c, f, i];

/** Returns a turned vector. */
export const turned = (m, [x, y, z]) => [m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z];

/** Returns the third column: where Z points. */
export const upward = (m) => [m[2], m[5], m[8]];

/** Returns the rotation of roll A, pitch B and yaw C in degrees: about the fixed axes X, then Y, then Z. */
export const ofRollPitchYaw = (a, b, c) => times(about(2, c * RADIANS), times(about(1, b * RADIANS), about(0, a * RADIANS)));

/** Returns a frame at X Y Z with roll, pitch and yaw in degrees. */
export const frame = (x, y, z, a, b, c) => ({ origin: [x, y, z], turn: ofRollPitchYaw(a, b, c) });

/** Returns a point given in a frame, relative to the frame's reference. */
export const pointOf = ({ origin, turn }, point) => plus(turned(turn, point), origin);

/** Returns a frame given in another, relative to the other's reference. */
export const joined = (outer, inner) => ({ origin: pointOf(outer, inner.origin), turn: times(outer.turn, inner.turn) });

/** Returns the reference of a frame relative to it. */
export function inverse({ origin, turn }) {
  const back = transposed(turn);
  return { origin: turned(back, origin).map((v) => -v), turn: back };
}
