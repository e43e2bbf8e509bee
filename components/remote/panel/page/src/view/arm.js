// Arms of six turning joints whose last three axes meet in the wrist: the closed form of `armkins`, as hal-arm has it.
//
// Angles are in degrees outside, in radians inside. `p` has the values of the pins and parameters of armkins.

import { IDENTITY, RADIANS, about, frame, inverse, pointOf, joined, times, transposed, turned } from "./rotation.js";

const { PI } = Math;
/** Sine, or share of the arm's size, below which a joint is not determined and stays. */
const UNDETERMINED = 1e-10;
/** How far the cosine of the elbow may be beyond ±1. */
const CLAMPED = 1e-9;
/** How far in degrees rounding may bring a joint beyond its limit. */
const EDGE = 1e-9;
const SIX = [0, 1, 2, 3, 4, 5];

const framed = (p, name) => frame(...["x", "y", "z", "a", "b", "c"].map((k) => p[`${name}.${k}`] ?? 0));
const modelled = (p, joints) => SIX.map((n) => (p[`offset-${n}`] + p[`sign-${n}`] * (joints[n] ?? 0)) * RADIANS);

/** Returns the frames of the links in the frame of poses, the arm's base first, the flange last. */
export function links(p, joints) {
  const rows = [[-PI / 2, p.A1, p.D1], [0, p.A2, 0], [PI / 2, p.A3, 0], [-PI / 2, 0, p.D4], [PI / 2, 0, 0], [0, 0, p.D6]];
  let at = inverse(framed(p, "frame"));
  const all = [at];
  modelled(p, joints).forEach((angle, i) => {
    const [alpha, a, d] = rows[i];
    const turn = about(2, angle);
    at = joined(at, { origin: turned(turn, [a, 0, d]), turn: times(turn, about(0, alpha)) });
    all.push(at);
  });
  return all;
}

/** Returns the frame of the tool's tip at these joints. */
export const tipOf = (p, joints) => joined(links(p, joints).at(-1), framed(p, "tool"));

/** Returns the joints that bring the tip to a frame: with the arm and elbow of `last` if that is possible, as along a path. */
export function jointsAlong(p, tip, last) {
  const now = configurationOf(p, last) & 6;
  return (p.config >= 0 ? null : jointsOf(p, tip, last, [now, now + 1])) ?? jointsOf(p, tip, last);
}

/** Returns the joints that bring the tip to a frame, of these solutions the nearest to `last`; null out of reach. */
export function jointsOf(p, tip, last, among = p.config >= 0 ? [p.config] : [0, 1, 2, 3, 4, 5, 6, 7]) {
  const flange = joined(joined(framed(p, "frame"), tip), inverse(framed(p, "tool")));
  let [best, least] = [null, Infinity];
  for (const configuration of among) {
    const joints = solve(p, flange, configuration, last);
    if (!joints) continue;
    const far = Math.max(...joints.map((v, n) => Math.abs(v - last[n])));
    if (far < least) [best, least] = [joints, far];
  }
  return best;
}

/** Returns the configuration of these joints. */
export function configurationOf(p, joints) {
  const [, shoulder, elbow, , wrist] = modelled(p, joints);
  const both = shoulder + elbow;
  const isBack = p.A1 + p.A2 * Math.cos(shoulder) + p.A3 * Math.cos(both) + p.D4 * Math.sin(both) < 0;
  const bend = Math.sin(elbow - PI / 2 + Math.atan2(p.A3, p.D4));
  const isDown = isBack ? bend > 0 : bend < 0;
  return (isBack ? 4 : 0) + (isDown ? 2 : 0) + (Math.sin(wrist) < 0 ? 1 : 0);
}

/** Returns the joints that bring the flange to a frame in one configuration, 4 · back + 2 · elbow down + flipped; null out of reach or limits. */
function solve(p, flange, configuration, last) {
  const front = configuration & 4 ? -1 : 1;
  const up = configuration & 2 ? -front : front;
  const wrist = pointOf(flange, [0, 0, -p.D6]);
  const before = modelled(p, last);
  const fore = Math.hypot(p.A3, p.D4);
  const size = p.A2 + fore;
  const across = Math.hypot(wrist[0], wrist[1]);
  const body = across > UNDETERMINED * size ? Math.atan2(front * wrist[1], front * wrist[0]) : before[0];
  const [out, down] = [front * across - p.A1, p.D1 - wrist[2]];
  const far = Math.hypot(out, down);
  const cosine = (far * far - p.A2 * p.A2 - fore * fore) / (2 * p.A2 * fore);
  if (!(Math.abs(cosine) <= 1 + CLAMPED)) return null;
  // As a product of lengths: nothing cancels.
  const square = (size - far) * (size + far) * (far - p.A2 + fore) * (far + p.A2 - fore);
  const bend = up * Math.atan2(square > 0 ? Math.sqrt(square) / (2 * p.A2 * fore) : 0, cosine);
  const shoulder = Math.atan2(down, out) - Math.atan2(fore * Math.sin(bend), p.A2 + fore * Math.cos(bend));
  const elbow = bend + PI / 2 - Math.atan2(p.A3, p.D4);
  const base = [about(2, body), about(0, -PI / 2), about(2, shoulder + elbow), about(0, PI / 2)].reduce(times, IDENTITY);
  const hand = times(transposed(base), flange.turn);
  return within(p, [body, shoulder, elbow, ...wrists(hand, Boolean(configuration & 1), before[3])], last);
}

/** Returns the angles of the wrist; a straight one keeps the first. */
function wrists(hand, isFlipped, last) {
  const sine = Math.hypot(hand[2], hand[5]);
  if (sine < UNDETERMINED) {
    const rest = times(about(2, -last), hand);
    return hand[8] > 0 ? [last, 0, Math.atan2(rest[3], rest[0])] : [last, PI, Math.atan2(rest[1], rest[4])];
  }
  const flip = isFlipped ? -1 : 1;
  return [Math.atan2(flip * hand[5], flip * hand[2]), Math.atan2(flip * sine, hand[8]), Math.atan2(flip * hand[7], -flip * hand[6])];
}

/** Returns the joints of these angles, turned within their limits and near the last; null beyond a limit. */
function within(p, angles, last) {
  const joints = [];
  for (const n of SIX) {
    const [min, max] = [p[`min-${n}`], p[`max-${n}`]];
    const angle = (angles[n] / RADIANS - p[`offset-${n}`]) / p[`sign-${n}`];
    const near = last[n] + (angle - last[n] - 360 * Math.round((angle - last[n]) / 360));
    const [first, end] = [Math.ceil((min - EDGE - near) / 360), Math.floor((max + EDGE - near) / 360)];
    if (!(first <= end)) return null;
    const turns = first > 0 ? first : end < 0 ? end : 0;
    joints.push(Math.max(min, Math.min(near + 360 * turns, max)));
  }
  return joints;
}
