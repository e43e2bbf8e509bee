// Lines drawn by the page itself. The picture is drawn again only when it changes.
//
// Without a graphics processor, WebGL draws a million lines in seconds, and the whole page waits behind them. Here they
// take a fraction of a second, and the page can pause between any two.

/** The colour word of a pixel that hides what is behind it. */
const OPAQUE = 0xff000000;
/** The part of a colour word without alpha. */
const RGB = 0xffffff;
/** Depth, in the width of pixels, by which a line may be behind another and yet be seen: lines that are side by side in a surface. */
const SLACK_PX = 2;

/** Returns a colour, red above green above blue, as a word whose bytes are red, green, blue and alpha in memory. */
export function word(colour, alpha = 255) {
  return ((alpha << 24) | ((colour & 255) << 16) | (colour & 0xff00) | ((colour >> 16) & 255)) >>> 0;
}

/** Pixels with depths, and the lines that are drawn into them. */
export class Raster {
  constructor(width, height) {
    this.width = width;
    this.height = height;
    this.pixels = new Uint32Array(width * height);
    this.depths = new Float32Array(width * height);
    this.clear();
  }

  clear() {
    this.pixels.fill(0);
    this.depths.fill(Infinity);
  }

  /** Looks through an orthographic camera: `matrix` has the 16 numbers, column by column, from points to -1 … 1. */
  look(matrix) {
    const [w, h] = [this.width / 2, this.height / 2];
    const row = (i) => [matrix[i], matrix[i + 4], matrix[i + 8], matrix[i + 12]];
    const [x, y, z] = [row(0), row(1), row(2)];
    this.x = x.map((v, i) => w * v + (i === 3 ? w : 0));
    this.y = y.map((v, i) => -h * v + (i === 3 ? h : 0));
    this.z = z;
    this.slack = (SLACK_PX * size(z)) / size(this.x);
  }

  /**
   * Draws the lines that end at points `first` up to `end`, and returns `end`: those whose kind `isDrawn` has true for.
   * Kind 0 is a point where no line ends. With a stride, lines join every so-many-th point.
   */
  draw({ points, origin, kinds, colours }, isDrawn, first, end, stride = 1) {
    const [ax, bx, cx, dx] = moved(this.x, origin);
    const [ay, by, cy, dy] = moved(this.y, origin);
    const [az, bz, cz, dz] = moved(this.z, origin);
    const { width, height } = this;
    let [x0, y0, z0] = [NaN, NaN, NaN];
    for (let i = Math.max(0, first - stride); i < end; i += stride) {
      const isLine = i >= first && isDrawn[kinds[i]];
      if (!isLine && !isDrawn[kinds[i + stride]]) continue;
      const [px, py, pz] = [points[3 * i], points[3 * i + 1], points[3 * i + 2]];
      const x1 = ax * px + bx * py + cx * pz + dx;
      const y1 = ay * px + by * py + cy * pz + dy;
      const z1 = az * px + bz * py + cz * pz + dz;
      const isOut = (x0 < 0 && x1 < 0) || (y0 < 0 && y1 < 0) || (x0 > width && x1 > width) || (y0 > height && y1 > height);
      if (isLine && !isOut) this.line(x0, y0, z0, x1, y1, z1, colours[i]);
      x0 = x1;
      y0 = y1;
      z0 = z1;
    }
    return end;
  }

  /**
   * Draws a line. In each column whose middle lies between its ends (of a steep line: in each row), it colours the two
   * nearest pixels by their shares. Lines in a row so take each column once.
   */
  line(x0, y0, z0, x1, y1, z1, colour) {
    const isSteep = Math.abs(y1 - y0) > Math.abs(x1 - x0);
    if (isSteep) [x0, y0, x1, y1] = [y0, x0, y1, x1];
    if (x0 > x1) [x0, y0, z0, x1, y1, z1] = [x1, y1, z1, x0, y0, z0];
    const { width, height } = this;
    const from = Math.max(0, Math.ceil(x0 - 0.5));
    const to = Math.min(isSteep ? height : width, Math.ceil(x1 - 0.5));
    if (!(from < to)) return;
    const [slope, rise] = [(y1 - y0) / (x1 - x0), (z1 - z0) / (x1 - x0)];
    const most = isSteep ? width : height;
    const [along, across] = isSteep ? [width, 1] : [1, width];
    for (let i = from; i < to; i++) {
      const t = i + 0.5 - x0;
      const y = y0 + t * slope - 0.5;
      const z = z0 + t * rise;
      const j = Math.floor(y);
      const share = y - j;
      const at = i * along + j * across;
      if (j >= 0 && j < most) this.dot(at, z, colour, 1 - share);
      if (j >= -1 && j + 1 < most) this.dot(at + across, z, colour, share);
    }
  }

  /** Colours a share of a pixel, unless something nearer is there. Shares of one colour add up: lines that are side by side leave no gaps. */
  dot(at, z, colour, share) {
    if (z > this.depths[at] + this.slack) return;
    const alpha = (colour >>> 24) * share;
    if (!(alpha >= 1)) return;
    if (share >= 0.5 && colour >= OPAQUE && z < this.depths[at]) this.depths[at] = z;
    const below = this.pixels[at];
    const [own, other] = [colour & RGB, below & RGB];
    if (below === 0 || own === other) {
      this.pixels[at] = ((Math.min(255, (below >>> 24) + alpha) << 24) | own) >>> 0;
      return;
    }
    const under = ((below >>> 24) * (255 - alpha)) / 255;
    const part = alpha / (alpha + under);
    const mix = (shift) => Math.round(((own >>> shift) & 255) * part + ((other >>> shift) & 255) * (1 - part)) << shift;
    this.pixels[at] = ((Math.round(alpha + under) << 24) | mix(0) | mix(8) | mix(16)) >>> 0;
  }
}

/** Returns how far the row of a map goes for a unit of length. */
function size([x, y, z]) {
  return Math.hypot(x, y, z);
}

/** Returns a row of the map for points without their origin. */
function moved([a, b, c, d], [x, y, z]) {
  return [a, b, c, d + a * x + b * y + c * z];
}

/** Lines that are added one by one. */
export class Lines {
  constructor() {
    this.points = [];
    this.origin = [0, 0, 0];
    this.kinds = [];
    this.colours = [];
  }

  add(from, to, colour) {
    this.points.push(...from, ...to);
    this.kinds.push(0, 2);
    this.colours.push(0, word(colour));
  }
}
