// Machines whose rotary axes tilt the tool or the table: where the tip is on the part, and where the tool points.
//
// `p` has the values of the pins of the kinematics, `sign` tells which way angles count, letters are the nine of a pose.
// Each returns what turns the tool in the machine, what turns the machine's frame to that of the part, and the tip on the
// part when the axes are at a place.

import { IDENTITY, RADIANS, about, aboutVector, minus, plus, times, turned, upward } from "./rotation.js";

/** A bridge mill whose head turns by C and tilts by B. */
function bridge(p, [, , , , b, c, , , w]) {
  const turn = times(about(2, c * RADIANS), about(1, -b * RADIANS));
  const pivot = p["pivot-length"];
  return { head: turn, table: IDENTITY, tip: (place) => minus(plus(place, [0, 0, pivot]), upward(turn).map((v) => (pivot + w) * v)) };
}

/** A head that tilts by B, a table that turns by C, and U V W with the head. */
function max(p, [, , , , b, c, u, v, w]) {
  const sign = p["conventional-directions"] ? -1 : 1;
  const head = about(1, -sign * b * RADIANS);
  const table = about(2, sign * c * RADIANS);
  const pivot = p["pivot-length"];
  const tip = (place) => turned(table, minus(plus(place, [0, 0, pivot]), turned(head, [u, v, pivot + w])));
  return { head, table, tip };
}

/** A table that tilts, and one that turns by C on it. */
function trunnion(tilts) {
  return (p, letters) => {
    const sign = p["conventional-directions"] ? 1 : -1;
    const tilt = about(tilts, sign * letters[3 + tilts] * RADIANS);
    const round = about(2, sign * letters[5] * RADIANS);
    const point = [p["x-rot-point"], p["y-rot-point"], p["z-rot-point"] + p["tool-offset"]];
    const offset = [p["x-offset"] ?? 0, p["y-offset"] ?? 0, p["z-offset"]];
    const tip = (place) => plus(turned(round, plus(turned(tilt, minus(minus(place, point), offset)), offset)), point);
    return { head: IDENTITY, table: times(round, tilt), tip };
  };
}

/** Two tables, B on top of A. */
function tables(p, [, , , a, b]) {
  const [outer, inner] = [about(0, a * RADIANS), about(1, b * RADIANS)];
  const point = [p["x-rot-point"], p["y-rot-point"], p["z-rot-point"] + p["tool-offset-z"]];
  const offset = [p["x-offset"], 0, p["z-offset"]];
  const tip = (place) => plus(turned(outer, minus(turned(inner, minus(place, point)), offset)), plus(offset, point));
  return { head: IDENTITY, table: times(outer, inner), tip };
}

/** A table that turns by A or B, and a head that turns by C and nods about a slanting axis. */
function nodding(turns) {
  const across = (side, z) => (turns === 0 ? [0, side, z] : [side, 0, z]);
  const letter = turns === 0 ? "y" : "x";
  return (p, letters) => {
    const lean = p["nut-angle"] * RADIANS;
    const nod = aboutVector(across(Math.sin(lean), Math.cos(lean)), letters[4 - turns] * RADIANS);
    const head = times(about(2, letters[5] * RADIANS), nod);
    const table = about(turns, letters[3 + turns] * RADIANS);
    const tool = across(-p[`${letter}-pivot`], -(p["z-pivot"] + p["tool-offset-z"]));
    const axis = across(p[`${letter}-rot-axis`], p["z-rot-axis"]);
    const tip = (place) => plus(turned(table, minus(plus(place, minus(turned(head, tool), tool)), axis)), axis);
    return { head, table, tip };
  };
}

/** Kinematics by the beginning of their pins; `own` is the type in which a pose is the tip on the part, `plane` one in which X Y Z are along the tool. */
export const FIVE_AXIS = {
  "5axiskins": { of: bridge, own: 0, letters: "XYZBCW" },
  maxkins: { of: max, own: 0, letters: "XYZABCUVW" },
  "xyzac-trt-kins": { of: trunnion(0), own: 0, letters: "XYZAC" },
  "xyzbc-trt-kins": { of: trunnion(1), own: 0, letters: "XYZBC" },
  xyzab_tdr_kins: { of: tables, own: 1, letters: "XYZAB" },
  xyzacb_trsrn: { of: nodding(0), own: 1, plane: 2, letters: "XYZACB" },
  xyzbca_trsrn: { of: nodding(1), own: 1, plane: 2, letters: "XYZBCA" },
};

/** Returns where the tool points on the part, and the tip on the part for a place of the axes. */
export function onPart(kind, p, letters) {
  const { head, table, tip } = kind.of(p, letters);
  return { axis: turned(table, upward(head)), tip };
}
