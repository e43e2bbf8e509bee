// The space that a tool passes on a straight way, whatever its direction: where upright lines enter and leave it.
//
// A tool is as long as it needs to be: half of a cylinder without end, flat or with a ball. Moved along a line it passes a
// convex space, so that a line meets it in one piece; the ends of that piece are ends of the parts that the space consists
// of, each of which is a plane, a cylinder or a sphere.

/** Length below which a way, or a part of one, has no direction. */
const SHORT = 1e-12;

/** The space that a tool passes whose tip goes from one point to another. */
export class Sweep {
  /** `axis` is the unit vector from the tip to the holder, `radius` that of the tool, `round` that of its ball or 0; `centre` is where the ball's centre is along the axis. */
  constructor({ from, to, axis, radius, centre }) {
    const way = from.map((v, i) => to[i] - v);
    this.along = dot(way, axis);
    const aside = way.map((v, i) => v - this.along * axis[i]);
    this.aside = length(aside);
    this.far = length(way);
    this.isAcross = this.aside > SHORT;
    // Coordinates of points beside the axis: along the way, and across it.
    const u = this.isAcross ? aside.map((v) => v / this.aside) : beside(axis);
    const v = cross(axis, u);
    const m = this.far > SHORT ? way.map((w) => w / this.far) : null;
    this.ball = centre > 0;
    const begin = from.map((p, i) => p + centre * axis[i]);
    Object.assign(this, { u, v, axis, m, begin, radius, square: radius * radius });
    this.tilt = u[2] * u[2] + v[2] * v[2];
    /** Heights between which the line that was asked for last is in the space. */
    this.low = 0;
    this.high = 0;
  }

  /** Returns whether an upright line meets the space. */
  meets(cx, cy) {
    const { u, v, axis, begin, aside, along, square } = this;
    const [ex, ey] = [cx - begin[0], cy - begin[1]];
    const ez = -begin[2];
    this.low = Infinity;
    this.high = -Infinity;
    const u0 = u[0] * ex + u[1] * ey + u[2] * ez;
    const v0 = v[0] * ex + v[1] * ey + v[2] * ez;
    const h0 = axis[0] * ex + axis[1] * ey + axis[2] * ez;
    const [uz, vz, hz] = [u[2], v[2], axis[2]];
    // The tool at the begin and at the end of its way.
    if (this.round(this.tilt, u0 * uz + v0 * vz, u0 * u0 + v0 * v0 - square) && this.above(h0, hz)) this.add();
    const w0 = u0 - aside;
    if (this.far > SHORT && this.round(this.tilt, w0 * uz + v0 * vz, w0 * w0 + v0 * v0 - square) && this.above(h0 - along, hz)) this.add();
    if (this.isAcross) {
      const slope = along / aside;
      // Between both, its sides.
      const { radius } = this;
      this.all();
      if (this.above(radius - v0, -vz) && this.above(radius + v0, vz) && this.above(u0, uz) && this.above(aside - u0, -uz)
        && this.above(h0 - slope * u0, hz - slope * uz)) this.add();
      // Below them, its flat end.
      if (!this.ball && Math.abs(along) > SHORT) {
        const lean = aside / along;
        const [a0, az] = [u0 - lean * h0, uz - lean * hz];
        const sign = along > 0 ? 1 : -1;
        if (this.round(az * az + vz * vz, a0 * az + v0 * vz, a0 * a0 + v0 * v0 - square)
          && this.above(sign * h0, sign * hz) && this.above(sign * (along - h0), -sign * hz)) this.add();
      }
    }
    if (this.ball) this.balls(ex, ey, ez);
    return this.low < this.high;
  }

  /** Adds the ball at both ends of its way, and between them. */
  balls(ex, ey, ez) {
    const { m, far, square } = this;
    const all = ex * ex + ey * ey + ez * ez - square;
    if (this.round(1, ez, all)) this.add();
    if (!m) return;
    const t0 = m[0] * ex + m[1] * ey + m[2] * ez;
    const tz = m[2];
    if (this.round(1, ez - far * tz, all - 2 * far * t0 + far * far)) this.add();
    if (this.round(1 - tz * tz, ez - t0 * tz, all - t0 * t0) && this.above(t0, tz) && this.above(far - t0, -tz)) this.add();
  }

  all() {
    this.from = -Infinity;
    this.to = Infinity;
  }

  /** Takes the heights z with a z² + 2 b z + c ≤ 0, and returns whether there are any. */
  round(a, b, c) {
    if (a < 1e-18) {
      this.all();
      return c <= 0;
    }
    const root2 = b * b - a * c;
    if (root2 < 0) return false;
    // Of both formulas for a root, the one in which nothing cancels.
    const t = b > 0 ? -b - Math.sqrt(root2) : -b + Math.sqrt(root2);
    const [one, other] = [t / a, t === 0 ? 0 : c / t];
    this.from = one < other ? one : other;
    this.to = one < other ? other : one;
    return true;
  }

  /** Leaves of these heights those with c + s z ≥ 0, and returns whether there are any. */
  above(c, s) {
    if (s > 0) {
      const z = -c / s;
      if (z > this.from) this.from = z;
    } else if (s < 0) {
      const z = -c / s;
      if (z < this.to) this.to = z;
    } else if (c < 0) return false;
    return this.from <= this.to;
  }

  /** Adds these heights to those of the space. */
  add() {
    if (this.from < this.low) this.low = this.from;
    if (this.to > this.high) this.high = this.to;
  }
}

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.sqrt(dot(a, a));

/** Returns a unit vector across another. */
export function beside(axis) {
  const least = [0, 1, 2].reduce((best, i) => (Math.abs(axis[i]) < Math.abs(axis[best]) ? i : best), 0);
  const found = cross(axis, [0, 1, 2].map((i) => (i === least ? 1 : 0)));
  const size = length(found);
  return found.map((v) => v / size);
}

/** Returns the corners, seen from above, of what the axis of a tool passes between the heights of a box: [x, y] each; null where it stays outside. */
export function shadow({ from, to, axis, radius }, low, high) {
  const [bottom, top] = [Math.min(from[2], to[2]), Math.max(from[2], to[2])];
  const lean = radius * Math.sqrt(Math.max(0, 1 - axis[2] * axis[2]));
  // Everything of the box is nearer than this.
  let far = radius + [0, 1, 2].reduce((sum, i) => sum + high[i] - low[i] + Math.max(Math.abs(from[i] - low[i]), Math.abs(to[i] - low[i])), 0);
  if (axis[2] > 0) {
    if (bottom - lean >= high[2]) return null;
    far = Math.min(far, (high[2] + lean - bottom) / axis[2]);
  } else if (axis[2] < 0) {
    if (top + lean <= low[2]) return null;
    far = Math.min(far, (top + lean - low[2]) / -axis[2]);
  } else if (bottom - lean >= high[2] || top + lean <= low[2]) return null;
  far = Math.max(far, radius);
  const end = ([x, y]) => [x + far * axis[0], y + far * axis[1]];
  return [from.slice(0, 2), to.slice(0, 2), end(to), end(from)];
}

/** Returns between which X lies what of a quadrangle is within reach of a row; null for nothing. */
export function spanOf(corners, cy, reach) {
  let [left, right] = [Infinity, -Infinity];
  for (let i = 0; i < 4; i++) {
    const [a, b] = [corners[i], corners[(i + 1) % 4]];
    const [from, to] = a[1] <= b[1] ? [a, b] : [b, a];
    if (to[1] < cy - reach || from[1] > cy + reach) continue;
    const rise = to[1] - from[1];
    const at = (y) => (rise > 0 ? from[0] + ((to[0] - from[0]) * Math.min(rise, Math.max(0, y - from[1]))) / rise : null);
    const ends = rise > 0 ? [at(cy - reach), at(cy + reach)] : [from[0], to[0]];
    left = Math.min(left, ...ends);
    right = Math.max(right, ...ends);
  }
  return left <= right ? [left - reach, right + reach] : null;
}
