//! Arcs as chords.

use super::{Error, MAX_POINTS, Problem};
use crate::rotation::{Vector, about};
use core::f64::consts::TAU;
use libm::{acos, atan2, ceil, fabs};

/// Largest distance of a chord from its arc, in millimetres.
const CHORD: f64 = 0.01;
/// Largest distance of an end from its circle, in millimetres.
const OFF: f64 = 0.05;

/// Circle about an axis, or cylinder.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Circle {
    pub(super) centre: Vector,
    /// Unit vector.
    pub(super) axis: Vector,
    pub(super) radius: f64,
}

impl Circle {
    /// Returns points on the arc from one point to another, the last being the end itself. It turns about the axis by the
    /// right hand, or against it if `is_reversed`; from a point to itself it turns once.
    pub(super) fn chords(
        &self,
        from: &Vector,
        to: &Vector,
        is_reversed: bool,
        fail: impl Fn(Problem) -> Error,
    ) -> Result<Vec<Vector>, Error> {
        let across = |p: &Vector| {
            let out = p - self.centre;
            out - self.axis * out.dot(&self.axis)
        };
        let (start, end) = (across(from), across(to));
        for out in [&start, &end] {
            let off = fabs(out.norm() - self.radius);
            // A point on the axis has no direction in which the arc could begin or end.
            if off > OFF || out.norm() < 1e-9 {
                return Err(fail(Problem::OffCircle(off)));
            }
        }
        let axis = if is_reversed { -self.axis } else { self.axis };
        let angle = atan2(start.cross(&end).dot(&axis), start.dot(&end));
        let is_whole = (to - from).norm() < 1e-6;
        let sweep = if is_whole {
            TAU
        } else if angle < 0.0 {
            angle + TAU
        } else {
            angle
        };
        let step =
            if self.radius > CHORD { 2.0 * acos(1.0 - CHORD / self.radius) } else { TAU / 4.0 };
        let count = ceil(sweep / step - 1e-9).max(1.0);
        if count > MAX_POINTS as f64 {
            return Err(fail(Problem::TooManyPoints));
        }
        let rise = (to - from).dot(&axis);
        let radii = (start.norm(), end.norm());
        let mut points = Vec::new();
        let mut n = 1.0;
        while n < count {
            let part = n / count;
            let radius = radii.0 + (radii.1 - radii.0) * part;
            let out = about(&axis, sweep * part) * start * (radius / radii.0);
            points.push(self.centre + axis * ((from - self.centre).dot(&axis) + rise * part) + out);
            n += 1.0;
        }
        points.push(*to);
        Ok(points)
    }
}
