//! Rounding: a path is rounded only as much as its feed needs.
//!
//! A blend of half the length bends twice as sharply. With w the speed that it should carry, it keeps the limits where
//! A2·w² is at most a share of A and A3·w³ one of J (`speed.rs`), and between lines A2 falls with the half and A3 with its
//! square. So the ratio of A2·w² to its limit, or the root of the ratio of A3·w³, is the factor by which the half is longer
//! than it has to be, or too short. Beside curves this holds nearly, and the factor is found again at the new half.
//!
//! A tolerance, and half of each segment, only bound the half. Where no half inside them carries the feed, the fastest is
//! taken: between lines the longest; beside curves a longer blend can be slower, because it replaces more of the curve.

use super::{Deviation, Planner, cells, pieces};
use crate::{
    blend::{self, Blend, Joint},
    bounds::Bounds,
    curve::Curve,
    join::{Join, Joining},
    kinematics::{Kinematics, joint_bounds},
    pose::{Group, Pose},
    segment::{Segment, Tolerances},
    speed::{Shares, Stretch},
};

/// Difference of directions, in the group whose corners are missed, below which there is no corner.
const STRAIGHT: f64 = 1e-4;

/// Shortest half that is chosen, so that the derivatives of a blend are still numbers.
const SHORTEST_HALF: f64 = 1e-6;

/// Reserve of a half, so that the feed and not the blend is the limit of its cells.
const RESERVE: f64 = 1.0 + 1e-6;

/// Part of a half below which a shorter one is worth another try.
const WORTH: f64 = 0.97;

/// Number of pieces of a blend that have a speed each: the motion is slower than its path coordinate in the middle, and makes
/// up for it there.
const QUARTERS: u16 = 4;

/// Largest number of halves that are tried beside a curve.
const TRIES: u8 = 8;

/// Part of the deviation of LinuxCNC's blends that a path without a tolerance may use; see [`free_deviation`].
const FREE: f64 = 0.97;

/// Factor by which a spline through dense lines may be further from them than the blend of their sharpest corner.
const SPLINE: f64 = 2.0;

/// Factor from one tolerance that is tried to the next, and the one by which a looser one must be faster.
const LOOSER: f64 = 8.0;
const MORE: f64 = 1.01;

/// Least length of lines with blends between them as a part of the way of a servo period: a line and its blend are five
/// cells, and the follower passes eight in a period.
const PER_PERIOD: f64 = 0.625;

/// Deviation of a blend between two lines as a part of its half and of the difference of their directions.
const DEVIATION: f64 = 3.0 / 16.0;

impl<K: Kinematics> Planner<K> {
    /// Returns the joint between two segments: smooth, the shortest blend that carries the feed, or a stop.
    pub(super) fn joint(&mut self, a: &Segment, b: &Segment) -> Joint {
        let room = 0.5 * a.length.min(b.length);
        let tolerances = self.tolerances(a, b);
        let longest = match blend::joint(a, b, room, &tolerances, self.law.has_jerk()) {
            Joint::Blend(longest) => longest,
            joint => return joint,
        };
        let chosen = self.shortest(a, b, &longest, &tolerances);
        for blend in [chosen, longest] {
            if self.certificate.allows(&blend, a, b, &tolerances)
                && self.has_joints(&blend.curve, 2.0 * blend.half, pieces(&blend))
            {
                return Joint::Blend(blend);
            }
            if chosen == longest {
                break;
            }
        }
        Joint::Stop
    }

    /// Returns the shortest blend that carries the feed, or the fastest one.
    fn shortest(&self, a: &Segment, b: &Segment, longest: &Blend, t: &Tolerances) -> Blend {
        let lines = matches!((&a.curve, &b.curve), (Curve::Line { .. }, Curve::Line { .. }));
        let longest = if t.is_bounded() { *longest } else { self.free(a, b, longest) };
        let stretch = self.stretch(&longest, a, b);
        let mut factor = stretch.factor();
        if factor > 1.0 {
            return if lines { longest } else { self.fastest(a, b, &longest, stretch) };
        }
        let (mut best, mut half) = (longest, longest.half);
        for _ in 0..TRIES {
            let next = (half * factor * RESERVE).max(SHORTEST_HALF);
            if next >= WORTH * best.half {
                break;
            }
            half = next;
            let blend = blend::of_half(a, b, half);
            factor = self.stretch(&blend, a, b).factor();
            if factor <= 1.0 {
                best = blend;
            }
        }
        best
    }

    /// Returns the longest blend of a path without a tolerance.
    fn free(&self, a: &Segment, b: &Segment, longest: &Blend) -> Blend {
        let (u, w) = (a.curve.at(a.length).first, b.curve.at(0.0).first);
        let half = self.free_half(&u, &w, a, b).max(SHORTEST_HALF);
        if half < longest.half { blend::of_half(a, b, half) } else { *longest }
    }

    /// Returns the half of a blend that deviates as far as a path without a tolerance may between these directions.
    fn free_half(&self, u: &Pose, w: &Pose, a: &Segment, b: &Segment) -> f64 {
        let turn = *w - *u;
        let size = turn.norm(a.main);
        if size < STRAIGHT {
            // What turns is another group, and no corner is missed.
            return f64::INFINITY;
        }
        let speed = self.speed_at(u, w, a, b);
        let most = self.law.acceleration(&turn).min(self.acceleration);
        let arcs = [a, b].map(|s| !matches!(s.curve, Curve::Line { .. }));
        let arcs = u8::from(arcs[0]) + u8::from(arcs[1]);
        let deviation = FREE * free_deviation(0.5 * size, arcs) * speed * speed / most;
        let half = deviation / (DEVIATION * size);
        match arcs {
            0 => half,
            _ => half.min(free_share(0.5 * size, arcs) * a.length.min(b.length)),
        }
    }

    /// Returns the speed for which the corner between these directions is rounded, which the axes reach in both.
    fn speed_at(&self, u: &Pose, w: &Pose, a: &Segment, b: &Segment) -> f64 {
        let wanted = cells::wanted([(a, u.norm(a.lead)), (b, w.norm(b.lead))]);
        let reached = [u, w].map(|slope| {
            let bounds = Bounds { first: slope.abs(), ..Bounds::default() };
            self.law.fastest(&bounds, None)
        });
        reached.into_iter().fold(wanted * self.machine.max_override, f64::min)
    }

    /// Returns the blend beside a curve that carries the largest part of the feed, up to the longest.
    fn fastest(&self, a: &Segment, b: &Segment, longest: &Blend, stretch: Stretch) -> Blend {
        let mut best = (*longest, stretch.carried());
        let mut step = 0.5;
        for _ in 0..TRIES {
            let halves = [best.0.half * step, best.0.half / step];
            let mut found = false;
            for half in halves {
                if !(SHORTEST_HALF..=longest.half).contains(&half) {
                    continue;
                }
                let blend = blend::of_half(a, b, half);
                let carried = self.stretch(&blend, a, b).carried();
                if carried > best.1 {
                    best = (blend, carried);
                    found = true;
                    break;
                }
            }
            if !found {
                step = f64::sqrt(step);
            }
        }
        best.0
    }

    /// Returns the factor by which a blend would have to be longer to carry the feed.
    fn stretch(&self, blend: &Blend, a: &Segment, b: &Segment) -> Stretch {
        // Behind a filter, a blend has one speed. The number of pieces is not that of its cells, which changes with the half.
        let count = if self.law.has_jerk() { 1 } else { QUARTERS };
        self.stretch_along(&blend.curve, 2.0 * blend.half, count, a, Some(b))
    }

    /// Returns the factor by which the curve of a segment, or of a blend between two, would have to be longer.
    fn stretch_along(
        &self,
        curve: &Curve,
        whole: f64,
        count: u16,
        a: &Segment,
        b: Option<&Segment>,
    ) -> Stretch {
        let shares = if b.is_some() { Shares::BLEND } else { Shares::MOVE };
        let mut worst = Stretch::NONE;
        let mut from = 0.0;
        for k in 1..=count {
            let to = whole * (f64::from(k) / f64::from(count));
            let bounds = curve.bounds(from, to, a.lead);
            let joints = if self.direct {
                None
            } else {
                joint_bounds(&self.kinematics, curve, from, to).ok()
            };
            let wanted = cells::wanted_along(curve, [from, to], &bounds, a, b);
            let speed = (wanted * self.machine.max_override)
                .min(self.law.fastest(&bounds, joints.as_ref()));
            let piece = self.law.stretch(&bounds, joints.as_ref(), speed, shares);
            let bend = bounds.second.norm(a.lead);
            let along = self.law.bend_share(bend, self.most(), shares) * speed * speed;
            worst = worst.max(piece).max(Stretch { acceleration: along, jerk: 0.0 });
            from = to;
        }
        worst
    }

    /// Joins the lines that wait, as closely as their feed permits: at the tightest of a few tolerances at which the
    /// spline carries it, or else at the one where it is fastest. Lines that no tight spline meets stay lines if they
    /// carry the feed themselves.
    pub(super) fn join_lines(&mut self, join: &mut Join, goes_on: bool) -> Vec<Segment> {
        let Some(first) = join.first() else { return Vec::new() };
        let most = self.tolerances(&first, &first);
        let (mut tolerances, lines_carry) = self.joining(join.lines(), &most);
        // The spline, and the length of the path that would take as long at full feed.
        let mut best: Option<(Joining, f64)> = None;
        loop {
            if let Some(found) = join.curve(goes_on, &tolerances, &most, &mut self.certificate) {
                let each = found.spacing();
                let parts = found.curves().iter().map(|curve| {
                    self.stretch_along(curve, each, 1, &first, None).carried().min(1.0)
                });
                let (mut slowest, mut length) = (1.0_f64, 0.0);
                for part in parts {
                    slowest = slowest.min(part);
                    length += each / part;
                }
                if best.as_ref().is_none_or(|(_, before)| length * MORE < *before) {
                    best = Some((found, length));
                }
                if slowest >= 1.0 {
                    break;
                }
            }
            if lines_carry || !most.is_bounded() || tolerances.linear >= most.linear {
                break;
            }
            tolerances.linear = (tolerances.linear * LOOSER).min(most.linear);
        }
        if let (Some(watched), Some((found, _))) = (&mut self.deviation, &best) {
            let (distance, line) = found.deviation(join.lines());
            note(watched, distance, line);
        }
        join.give(goes_on, best.map(|(found, _)| found))
    }

    /// Notes how far a blend is from its corner, if that is watched.
    pub(super) fn note_corner(&mut self, blend: &Blend, b: &Segment, line: u32) {
        if let Some(watched) = &mut self.deviation {
            let by = blend.curve.pose(blend.half) - b.curve.pose(0.0);
            note(watched, by.norm(Group::Xyz).max(by.norm(Group::Uvw)), line);
        }
    }

    /// Returns the tolerances within which lines are joined: as far from them as the feed needs at the sharpest of their
    /// corners, never further than `t`, and never closer than in exact mode. Returns true as well if blends between the
    /// lines themselves carry the feed.
    fn joining(&self, lines: &[Segment], t: &Tolerances) -> (Tolerances, bool) {
        let (mut linear, mut carry) = (0.0_f64, true);
        for pair in lines.windows(2) {
            let [a, b] = pair else { continue };
            let (Curve::Line { slope: u, .. }, Curve::Line { slope: w, .. }) = (&a.curve, &b.curve)
            else {
                continue;
            };
            let turn = *w - *u;
            let speed = self.speed_at(u, w, a, b);
            let mut half = self.law.half(&turn, speed, self.most()).factor();
            let (short, size) = (a.length.min(b.length), turn.norm(a.main));
            let most = t.linear / (DEVIATION * size);
            carry &=
                half <= most.min(0.5 * short) && short >= PER_PERIOD * speed * self.machine.period;
            if !t.is_bounded() {
                half = half.min(0.5 * short).min(self.free_half(u, w, a, b));
            }
            linear = linear.max(DEVIATION * half * size);
        }
        let linear = (SPLINE * linear).max(self.machine.exact_tolerance);
        (Tolerances { linear: linear.min(t.linear), angular: t.angular }, carry)
    }

    /// Returns the highest acceleration along the path.
    pub(super) fn most(&self) -> f64 {
        // Along the path, the filter changes the acceleration by all of it in its length.
        let jerk = if self.law.has_jerk() { self.jerk * self.law.time() } else { f64::INFINITY };
        self.acceleration.min(jerk)
    }
}

/// Keeps the larger deviation.
const fn note(watched: &mut Deviation, distance: f64, line: u32) {
    if distance > watched.distance {
        *watched = Deviation { distance, line };
    }
}

/// Returns the deviation of a corner of LinuxCNC 2.9 that carries its feed, times acceleration and per squared feed; `sin` is
/// the sine of half of the angle, `arcs` the number of segments that are not lines.
///
/// It is an arc of radius v²/(0.87·A) where the angle is large, and a longer one where it is small, less so beside arcs. Between
/// arcs that lead back it is much shorter. The function is below each of the corners that were measured
/// (`components/motion/motion/CORNERS.md`).
fn free_deviation(sin: f64, arcs: u8) -> f64 {
    let cos = (1.0 - sin * sin).max(1e-9).sqrt();
    let small = if arcs == 0 { 0.78 } else { 0.45 };
    let size = if leads_back(sin, arcs) { 0.43 } else { 1.15 };
    size * (1.0 / cos - 1.0) * (small / sin.max(1e-9)).max(1.0)
}

/// Returns the longest half beside an arc as a part of the shorter segment, from the same measurements: LinuxCNC keeps more
/// of its arcs than of its lines, and nearly all of an arc that leads back.
const fn free_share(sin: f64, arcs: u8) -> f64 {
    if leads_back(sin, arcs) || 0.97 <= sin { 0.017 } else { 0.08 }
}

/// Returns whether an arc leads back from an arc.
const fn leads_back(sin: f64, arcs: u8) -> bool {
    arcs == 2 && 0.9 <= sin
}
