//! Blends: curves that replace a corner, with continuous first and second derivatives and a certified deviation.
//!
//! A blend is the curve of degree five between the point `half` before the corner and the point `half` after it. Its
//! distance from the programmed path is bounded in closed form, never by samples:
//!
//! - Between two lines with directions u and w, the blend leaves the first line by (w − u)·half·(x³/4 − x⁴/16) for
//!   x = s/half, so the deviation is at most 3/16·half times the part of w − u at right angles to the line.
//! - Between other curves, each half is split into pieces. On a piece, D is the difference between the blend and the
//!   curve of degree five through the programmed curve's ends (with two derivatives). D lies in the hull of its
//!   Bernstein coefficients. The part of D along the path is taken off by moving along the path by the coordinate
//!   `slip`, which costs the terms `slip·turn` and `curvature·slip²/2`; the programmed curve itself deviates from its
//!   interpolant by at most R·(ωh)⁶/46080.

use crate::{
    curve::{Curve, Derivatives},
    pose::{Group, Pose},
    segment::{Segment, Tolerances},
};

/// A blend between two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Blend {
    pub(crate) curve: Curve,
    /// Path length that it replaces on either side.
    pub(crate) half: f64,
}

/// Pieces per half that the deviation bound uses.
const PIECES: u8 = 4;

/// Shortest half of a blend; a tighter corner is an exact stop.
const SHORTEST_HALF: f64 = 1e-7;

/// The corner itself is missed by at most this many tolerances.
const CORNER_MISS: f64 = 1.5;

/// Cosine of the angle between the way back and the second segment, above which the motion comes to rest: 0.003°.
const STRAIGHT_BACK: f64 = 1.0 - 1e-9;

/// Kind of joint between two segments.
#[expect(clippy::large_enum_variant, reason = "lives on the stack for a moment")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Joint {
    /// The derivatives that matter are continuous.
    Smooth,
    /// A blend leads from one to the other.
    Blend(Blend),
    /// The motion comes to rest.
    Stop,
}

/// Finds the joint between `a` and `b`, with the longest blend inside the tolerances. `room` is the longest half, and `jerk` is true if second derivatives must be
/// continuous.
pub(crate) fn joint(a: &Segment, b: &Segment, room: f64, t: &Tolerances, jerk: bool) -> Joint {
    if b.smooth {
        return Joint::Smooth;
    }
    let (e, f) = (a.curve.at(a.length), b.curve.at(0.0));
    let kink = f.first - e.first;
    let bend = f.second - e.second;
    let size = e.first.dot_all(&e.first).sqrt();
    if kink.dot_all(&kink).sqrt() < 1e-11 * size
        && (!jerk || bend.dot_all(&bend).sqrt() < 1e-11 * size)
    {
        return Joint::Smooth;
    }
    let lengths = e.first.dot_all(&e.first) * f.first.dot_all(&f.first);
    if e.first.dot_all(&f.first) < -STRAIGHT_BACK * lengths.sqrt() {
        return Joint::Stop;
    }
    let found = match (&a.curve, &b.curve) {
        (Curve::Line { slope: u, .. }, Curve::Line { slope: w, .. }) => {
            between_lines(a, b, u, w, room, t)
        }
        _ => between_curves(a, b, room, t, size),
    };
    found.map_or(Joint::Stop, Joint::Blend)
}

/// Blend between two lines, in closed form.
fn between_lines(
    a: &Segment,
    b: &Segment,
    u: &Pose,
    w: &Pose,
    room: f64,
    t: &Tolerances,
) -> Option<Blend> {
    let turn = *w - *u;
    let along = |v: &Pose, main: Group| turn.dot(v, main) / v.dot(v, main);
    let (on_a, on_b) = (along(u, a.main), along(w, b.main));
    let (off_a, off_b) = (turn - *u * on_a, turn - *w * on_b);
    let mut worst: f64 = 0.0;
    for group in Group::ALL {
        let past_a = on_a.max(0.0) * u.norm(group);
        let past_b = (-on_b).max(0.0) * w.norm(group);
        let off = (off_a.norm(group) + past_a).max(off_b.norm(group) + past_b);
        worst = worst.max(off.max(turn.norm(group) / CORNER_MISS) / t.of(group));
    }
    let half = room.min((1.0 - 1e-9) * 16.0 / 3.0 / worst);
    (half >= SHORTEST_HALF).then(|| of_half(a, b, half))
}

/// Blend with an arc or polynomial: the longest half, to about 1.5 %, whose bound is inside the tolerance.
fn between_curves(a: &Segment, b: &Segment, room: f64, t: &Tolerances, size: f64) -> Option<Blend> {
    let mut most = room;
    for segment in [a, b] {
        if let Curve::Arc { rate, .. } = segment.curve {
            most = most.min(0.8 / rate.abs());
        }
    }
    let kink = b.curve.at(0.0).first - a.curve.at(a.length).first;
    let tangent = kink.dot_all(&kink).sqrt() < 1e-6 * size;
    let (mut low, mut high) = ((0.0, 0.0), (f64::INFINITY, 0.0));
    let mut best = None;
    let mut half = most;
    for round in 0..16 {
        if half < SHORTEST_HALF {
            break;
        }
        let blend = of_half(a, b, half);
        let ratio = deviation(&blend, a, b, t);
        if ratio <= 1.0 {
            if half > low.0 {
                low = (half, ratio);
                best = Some(blend);
            }
            if half >= most * (1.0 - 1e-12) || ratio >= 0.985 || round >= 9 {
                break;
            }
        } else {
            high = (half, ratio);
        }
        // The deviation grows with a power of the half: 1 at a corner, 2 or 3 at a tangent joint.
        let mut power = if tangent { 2.0 } else { 1.5 };
        if low.0 > 0.0 && high.0 < f64::INFINITY && low.1 > 0.0 {
            power = libm::log(high.1 / low.1) / libm::log(high.0 / low.0);
            power = if power > 0.3 { power.min(4.0) } else { 0.3 };
        }
        let mut next = half * libm::pow(0.995 / ratio.max(1e-9), 1.0 / power);
        if high.0 < f64::INFINITY {
            let bound = if low.0 > 0.0 { low.0 + 0.97 * (high.0 - low.0) } else { 0.98 * high.0 };
            next = next.min(bound);
        }
        next = next.max(low.0 * 1.0001).min(most);
        if (next - half).abs() < 1e-4 * half {
            break;
        }
        half = next;
    }
    best
}

/// Returns the blend with this half.
pub(crate) fn of_half(a: &Segment, b: &Segment, half: f64) -> Blend {
    Blend { curve: curve(a, b, half), half }
}

fn curve(a: &Segment, b: &Segment, half: f64) -> Curve {
    Curve::hermite(&a.curve.twice(a.length - half), &b.curve.twice(half), 2.0 * half)
}

/// Bounds the largest ratio of a blend's distance from the path to the tolerance.
pub(crate) fn deviation(blend: &Blend, a: &Segment, b: &Segment, t: &Tolerances) -> f64 {
    let d = blend.half;
    let first = half_deviation(&blend.curve, 0.0, a, a.length - d, d, t);
    let second = half_deviation(&blend.curve, d, b, 0.0, d, t);
    first.max(second).max(miss(blend, b, t))
}

/// Returns the ratio of the distance between the corner and the middle of the blend to its bound.
fn miss(blend: &Blend, b: &Segment, t: &Tolerances) -> f64 {
    t.ratio(&(blend.curve.pose(blend.half) - b.curve.pose(0.0))) / CORNER_MISS
}

/// Bounds the ratio again for the certificate. Between lines this is independent of [`joint`]: the distance from a line is
/// convex, so over the hull of a half it is largest at a Bernstein point. Beside other curves it is the bound of [`joint`]
/// on pieces half as long, and, where that does not suffice, the bound of [`joint`] itself.
pub(crate) fn deviation_again(blend: &Blend, a: &Segment, b: &Segment, t: &Tolerances) -> f64 {
    let d = blend.half;
    let (Curve::Line { .. }, Curve::Line { .. }) = (&a.curve, &b.curve) else {
        let halves = [(0.0, a, a.length - d), (d, b, 0.0)];
        let worst = halves.map(|(at, segment, from)| {
            let (one, two) = (0.5 * d, from + 0.5 * d);
            half_deviation(&blend.curve, at, segment, from, one, t).max(half_deviation(
                &blend.curve,
                at + one,
                segment,
                two,
                one,
                t,
            ))
        });
        let again = worst[0].max(worst[1]).max(miss(blend, b, t));
        // Both are bounds; the finer one is not always the lower.
        return if again <= 1.0 { again } else { again.min(deviation(blend, a, b, t)) };
    };
    let Curve::Poly { c, .. } = &blend.curve else { return f64::INFINITY };
    let mut worst = miss(blend, b, t);
    for (points, segment) in halves(c).iter().zip([a, b]) {
        let (start, end) = (segment.curve.pose(0.0), segment.curve.pose(segment.length));
        let by = end - start;
        let square = by.dot(&by, segment.main);
        worst = worst.max(t.ratios(points.map(|point| {
            let from = point - start;
            let share = from.dot(&by, segment.main) / square;
            let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
            from - by * share
        })));
    }
    worst
}

/// Bernstein points of both halves of a polynomial of degree five, by de Casteljau's construction.
fn halves(c: &[Pose; 6]) -> [[Pose; 6]; 2] {
    let [c0, c1, c2, c3, c4, c5] = *c;
    let mut points = [
        c0,
        c0 + c1 * 0.2,
        c0 + c1 * 0.4 + c2 * 0.1,
        c0 + c1 * 0.6 + c2 * 0.3 + c3 * 0.1,
        c0 + c1 * 0.8 + c2 * 0.6 + c3 * 0.4 + c4 * 0.2,
        c0 + c1 + c2 + c3 + c4 + c5,
    ];
    let mut first = [c0; 6];
    for (k, slot) in first.iter_mut().enumerate().skip(1) {
        // After k rounds, the first points that are left are those of the second half.
        for i in 0..6 - k {
            if let Some([a, b]) = points.get_mut(i..i + 2) {
                *a = (*a + *b) * 0.5;
            }
        }
        *slot = points[0];
    }
    [first, points]
}

/// Bounds the deviation over one half: the blend from `at`, beside the segment from `from`.
fn half_deviation(
    blend: &Curve,
    at: f64,
    segment: &Segment,
    from: f64,
    d: f64,
    t: &Tolerances,
) -> f64 {
    let h = d / f64::from(PIECES);
    let main = segment.main;
    // Bounds on a piece: of the second derivative; of the distance between the curve and its interpolant; of the change of
    // the first derivative from the mean of both ends.
    let (curvature, rest, turn) = match &segment.curve {
        Curve::Line { .. } => (0.0, 0.0, 0.0),
        Curve::Arc { arm, rate, .. } => {
            let radius = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
            let w = rate.abs();
            let wh = w * h;
            let half = 0.5 * wh;
            (
                radius * w * w,
                radius * wh * wh * wh * wh * wh * wh / 46080.0,
                radius * w * (half + half * half),
            )
        }
        Curve::Poly { .. } => {
            // A polynomial of degree five is its own interpolant.
            let bounds = segment.curve.bounds(from, from + d, segment.lead);
            let k = bounds.second.dot_all(&bounds.second).sqrt();
            (k, 0.0, k * h)
        }
    };
    let difference = |k: u8| {
        let x = h * f64::from(k);
        let (p, q) = (blend.twice(at + x), segment.curve.twice(from + x));
        let d = Derivatives {
            pose: p.pose - q.pose,
            first: p.first - q.first,
            second: p.second - q.second,
            third: Pose::ZERO,
        };
        (d, q.first)
    };
    let mut worst: f64 = 0.0;
    let mut left = difference(0);
    // In a group in which neither of them moves, they differ nowhere if not at the start.
    let moving = Group::ALL.map(|group| {
        left.0.pose.group(group) != [0.0; 3] || blend.moves(group) || segment.curve.moves(group)
    });
    for k in 1..=PIECES {
        let right = difference(k);
        let u = left.1 + right.1;
        let mean = 0.5 * u.norm(main);
        if mean.is_nan() || mean <= 0.0 {
            return f64::INFINITY;
        }
        let u = u * (0.5 / mean);
        let hull = left.0.bernstein(&right.0, h);
        let (mut slip, mut past) = (0.0_f64, 0.0_f64);
        let mut off = [0.0_f64; 3];
        for (i, point) in hull.iter().enumerate() {
            let along = point.dot(&u, main) / mean;
            #[expect(clippy::cast_precision_loss, reason = "below 6")]
            let x = from + h * (f64::from(k - 1) + i as f64 / 5.0) + along;
            past = past.max(x - segment.length).max(-x);
            slip = slip.max(along.abs());
            let dot = point.dot(&u, main);
            for ((o, group), moves) in off.iter_mut().zip(Group::ALL).zip(moving) {
                if moves {
                    let ([a, b, c], [x, y, z]) = (point.group(group), u.group(group));
                    let (a, b, c) = (a - x * dot, b - y * dot, c - z * dot);
                    *o = o.max(a * a + b * b + c * c);
                }
            }
        }
        for (o, group) in off.map(f64::sqrt).iter().zip(Group::ALL) {
            // Only XYZ of an arc turns; a polynomial may turn in every group.
            let turns = group == Group::Xyz || matches!(segment.curve, Curve::Poly { .. });
            let bent = slip * turn + 0.5 * curvature * slip * slip + rest;
            let fast = u.norm(group) * mean + if turns { turn } else { 0.0 };
            let bound = o + past * fast + if turns { bent } else { 0.0 };
            worst = worst.max(bound * (1.0 + 1e-9) / t.of(group));
        }
        left = right;
    }
    worst
}
