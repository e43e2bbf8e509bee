//! Realtime. Poses along a programmed move, and its length.

use hal_component::Pose;
use hal_trajectory::Shape;
use libm::{atan2, cos, fabs, sin, sqrt};

const TAU: f64 = core::f64::consts::TAU;

/// Angles below this are rounding: an arc that ends where it starts is a full turn.
const FULL: f64 = 1e-7;

/// A move from its start to its end, by a parameter from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweep {
    start: Pose,
    end: Pose,
    arc: Option<Arc>,
}

/// The circular part of an arc.
#[derive(Clone, Copy, Debug)]
struct Arc {
    center: [f64; 3],
    axis: [f64; 3],
    /// From the centre, at its height, to the start; and the same length at a right angle to it.
    arm: [f64; 3],
    side: [f64; 3],
    /// Angle in radians, above 0.
    angle: f64,
    /// Radius of the end divided by that of the start.
    ratio: f64,
    /// Height of the start and the end above the centre.
    low: f64,
    high: f64,
}

impl Sweep {
    /// Sweep of a shape. An arc without radius or axis is a line; the planner refuses it.
    pub(crate) fn new(start: &Pose, shape: &Shape) -> Self {
        match shape {
            Shape::Line { end } => Self { start: *start, end: end.0, arc: None },
            Shape::Arc { end, center, normal, turns } => {
                Self { start: *start, end: end.0, arc: arc(start, &end.0, center, normal, *turns) }
            }
        }
    }

    /// Returns the pose at a parameter from 0 to 1.
    pub(crate) fn at(&self, t: f64) -> Pose {
        let mut pose = self.start;
        for (p, end) in pose.iter_mut().zip(&self.end) {
            *p += (end - *p) * t;
        }
        if let Some(a) = &self.arc {
            let (c, s) = (cos(a.angle * t), sin(a.angle * t));
            let r = 1.0 + (a.ratio - 1.0) * t;
            let height = a.low + (a.high - a.low) * t;
            let parts = a.center.iter().zip(&a.axis).zip(&a.arm).zip(&a.side);
            for (p, (((center, axis), arm), side)) in pose.iter_mut().zip(parts) {
                *p = center + axis * height + (arm * c + side * s) * r;
            }
        }
        pose
    }

    /// Returns the parameter at which X, Y or Z has the `n`-th extreme value, if there is one.
    pub(crate) fn extreme(&self, axis: usize, n: u32) -> Option<f64> {
        let a = self.arc.as_ref()?;
        let first = atan2(*a.side.get(axis)?, *a.arm.get(axis)?);
        let half = 0.5 * TAU;
        let first = if first < 0.0 { first + half } else { first };
        let t = (first + half * f64::from(n)) / a.angle;
        (t < 1.0).then_some(t)
    }

    /// Returns the length that governs the feed: of XYZ, else of UVW, else of ABC.
    pub(crate) fn length(&self) -> f64 {
        let part = |from: usize| {
            let ways = self.start.iter().zip(&self.end).skip(from).take(3);
            sqrt(ways.map(|(s, e)| (e - s) * (e - s)).sum())
        };
        if let Some(a) = &self.arc {
            let round = norm(&a.arm) * a.angle;
            let rise = a.high - a.low;
            return sqrt(round * round + rise * rise);
        }
        let [linear, rotary, extra] = [part(0), part(3), part(6)];
        if linear > 0.0 {
            linear
        } else if extra > 0.0 {
            extra
        } else {
            rotary
        }
    }

    /// Returns the centre of the arc, and the radius of its start.
    pub(crate) fn circle(&self) -> ([f64; 3], f64) {
        self.arc.map_or(([0.0; 3], 0.0), |a| (a.center, norm(&a.arm)))
    }

    /// Returns the angle of the arc in turns.
    pub(crate) fn turns(&self) -> f64 {
        self.arc.map_or(0.0, |a| a.angle / TAU)
    }
}

/// Returns the rest of a shape from a pose on it. `ahead` is the angle that is left, in turns.
pub(crate) fn rest(shape: &Shape, from: &Pose, ahead: f64) -> Shape {
    let Shape::Arc { end, center, normal, .. } = shape else { return *shape };
    let once = Shape::Arc { end: *end, center: *center, normal: *normal, turns: 0 };
    let part = Sweep::new(from, &once).turns();
    let turns = libm::rint(ahead - part);
    if turns < 0.0 {
        // The motion is at the end but for rounding; once more around is not meant.
        return Shape::Line { end: *end };
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 1e6")]
    let turns = if turns < 1e6 { turns as u32 } else { 0 };
    Shape::Arc { end: *end, center: *center, normal: *normal, turns }
}

fn arc(start: &Pose, end: &Pose, center: &[f64; 3], normal: &[f64; 3], turns: u32) -> Option<Arc> {
    let size = norm(normal);
    if !(size > 1e-12 && size.is_finite()) {
        return None;
    }
    let axis = normal.map(|x| x / size);
    let from = minus(start, center);
    let to = minus(end, center);
    let (low, high) = (dot(&from, &axis), dot(&to, &axis));
    let (arm, last) = (flat(&from, &axis, low), flat(&to, &axis, high));
    let (r0, r1) = (norm(&arm), norm(&last));
    if !(r0 > 1e-9 && r1 > 1e-9) {
        return None;
    }
    let [a, b, c] = axis;
    let [x, y, z] = arm;
    let side = [b * z - c * y, c * x - a * z, a * y - b * x];
    let mut angle = atan2(dot(&last, &side), dot(&last, &arm));
    if angle < FULL {
        angle += TAU;
    }
    let angle = angle + TAU * f64::from(turns);
    Some(Arc { center: *center, axis, arm, side, angle, ratio: r1 / r0, low, high })
}

fn minus(pose: &Pose, center: &[f64; 3]) -> [f64; 3] {
    let mut out = [0.0; 3];
    for (o, (p, c)) in out.iter_mut().zip(pose.iter().zip(center)) {
        *o = p - c;
    }
    out
}

/// Returns a vector without its part along the axis.
fn flat(v: &[f64; 3], axis: &[f64; 3], height: f64) -> [f64; 3] {
    let mut out = *v;
    for (o, a) in out.iter_mut().zip(axis) {
        *o -= a * height;
    }
    out
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn norm(v: &[f64; 3]) -> f64 {
    sqrt(fabs(dot(v, v)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(turns: u32, end: [f64; 3]) -> Shape {
        let end = hal_trajectory::Pose::from_xyz(end);
        Shape::Arc { end, center: [0.0; 3], normal: [0.0, 0.0, 2.0], turns }
    }

    #[test]
    fn a_helix_passes_its_extremes() {
        let mut start = [0.0; 9];
        start[0] = 10.0;
        let whole = Sweep::new(&start, &around(1, [0.0, 10.0, 5.0]));
        assert!((whole.turns() - 1.25).abs() < 1e-12);
        let round = 1.25 * TAU * 10.0;
        assert!((whole.length() - round.hypot(5.0)).abs() < 1e-9);
        let ends: Vec<Pose> =
            (0..10).filter_map(|n| whole.extreme(0, n)).map(|t| whole.at(t)).collect();
        let xs: Vec<f64> = ends.iter().map(|p| (p[0] * 1e9).round() / 1e9).collect();
        assert_eq!(xs, [10.0, -10.0, 10.0]);
        let last = whole.at(1.0);
        assert!(last[0].abs() < 1e-9 && (last[1] - 10.0).abs() < 1e-9 && last[2] == 5.0);
    }

    #[test]
    fn the_rest_of_turns_is_no_turn_more() {
        let mut start = [0.0; 9];
        start[0] = 10.0;
        let shape = around(2, [10.0, 0.0, 0.0]);
        let whole = Sweep::new(&start, &shape);
        assert!((whole.turns() - 3.0).abs() < 1e-12);
        for part in [0.0, 0.1, 0.3, 0.5, 0.7, 0.99, 1.0] {
            let from = whole.at(part);
            let left = rest(&shape, &from, 3.0 * (1.0 - part));
            let turns = Sweep::new(&from, &left).turns();
            assert!((turns - 3.0 * (1.0 - part)).abs() < 1e-6, "{part}: {turns}");
        }
    }
}
