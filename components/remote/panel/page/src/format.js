// Numbers as they are shown.

export const AXES = "xyzabcuvw";
const MM_PER_INCH = 25.4;

/** Returns whether an axis turns. */
export const isAngular = (axis) => "abc".includes(axis);

/** Units of length: factors from and to those of the machine. */
export class Units {
  /** `machine` and `shown` are "mm" or "inch". */
  constructor(machine, shown) {
    this.name = shown;
    this.factor = machine === shown ? 1 : shown === "mm" ? MM_PER_INCH : 1 / MM_PER_INCH;
    this.digits = shown === "mm" ? 3 : 4;
  }

  /** Returns a length in the units that are shown. */
  show(value) {
    return value * this.factor;
  }

  /** Returns a length of the units that are shown in those of the machine. */
  read(value) {
    return value / this.factor;
  }

  /** Returns the text of a position. */
  text(value, axis = "x") {
    if (!Number.isFinite(value)) return "—";
    const shown = isAngular(axis) ? value.toFixed(3) : this.show(value).toFixed(this.digits);
    return Number(shown) === 0 ? shown.replace("-", "") : shown;
  }

  /** Returns the unit of an axis. */
  unit(axis) {
    return isAngular(axis) ? "°" : this.name === "mm" ? "mm" : "in";
  }
}

/** Returns a time as minutes and seconds, or hours. */
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "—";
  const all = Math.max(0, Math.round(seconds));
  const two = (n) => String(n).padStart(2, "0");
  const [h, m, s] = [Math.floor(all / 3600), Math.floor(all / 60) % 60, all % 60];
  return h > 0 ? `${h}:${two(m)}:${two(s)}` : `${m}:${two(s)}`;
}

/** Returns a time that is given in nanoseconds, with the unit that leaves few digits. */
export function time(ns) {
  const all = Number(ns);
  const [size, unit] = [[1e9, "s"], [1e6, "ms"], [1e3, "µs"]].find(([size]) => size <= Math.abs(all)) ?? [1, "ns"];
  return `${Number((all / size).toPrecision(4))} ${unit}`;
}

/** Returns a number of bytes. */
export function bytes(n) {
  if (n < 1000) return `${n} B`;
  return n < 1e6 ? `${(n / 1e3).toFixed(1)} kB` : `${(n / 1e6).toFixed(1)} MB`;
}

/** Returns the name of a G code that is given times ten. */
export function gCode(times10) {
  return Number.isInteger(times10 / 10) ? `G${times10 / 10}` : `G${(times10 / 10).toFixed(1)}`;
}

/** Reads a length with an optional unit ("1mm", ".5in", "1/16") in machine units; null if it is none. */
export function length(text, machineUnit) {
  const found = /^\s*([0-9.]+)(?:\/([0-9.]+))?\s*(mm|cm|um|in|inch|mil)?\s*$/.exec(text);
  if (!found) return null;
  const value = Number(found[1]) / Number(found[2] ?? 1);
  if (!Number.isFinite(value)) return null;
  const inMm = { mm: 1, cm: 10, um: 0.001, in: MM_PER_INCH, inch: MM_PER_INCH, mil: MM_PER_INCH / 1000 };
  const unit = found[3] ?? machineUnit;
  return (value * inMm[unit]) / inMm[machineUnit];
}
