//! The curve of an arc or helix in the file, and its points.

use super::{
    Reason,
    arc::{Arc, Failure},
    modal::{ArcPlane, Modal},
};
use crate::Vector;
use core::f64::consts::{PI, TAU};
use libm::{fabs, sqrt};

/// Largest number of lines for an arc.
const MAX_CHORDS: f64 = 100_000.0;

/// Indices of the axes of a plane, and of the axis across it.
const fn axes(plane: ArcPlane) -> [usize; 3] {
    match plane {
        ArcPlane::Xy | ArcPlane::Other => [0, 1, 2],
        ArcPlane::Zx => [2, 0, 1],
        ArcPlane::Yz => [1, 2, 0],
    }
}

/// Curve of an arc or helix in the file.
pub(super) struct Curve {
    axes: [usize; 3],
    centre: [f64; 2],
    /// Angle of the start, and of the way, in radians.
    from: f64,
    sweep: f64,
    radii: [f64; 2],
    across: [f64; 2],
}

/// Returns the coordinate of an axis.
fn on(point: [f64; 3], axis: usize) -> f64 {
    point.get(axis).copied().unwrap_or(0.0)
}

impl Curve {
    pub(super) fn new(
        modal: &Modal,
        arc: &Arc,
        start: [f64; 3],
        stop: [f64; 3],
    ) -> Result<Self, Failure> {
        let axes = axes(modal.now.plane);
        let [first, second, across] = axes;
        let flat = |p| Vector::new(on(p, first), on(p, second));
        let (s, e) = (flat(start), flat(stop));
        let word = |axis: usize| arc.centre.get(axis).copied().flatten();
        let centre = match (arc.radius, word(first), word(second)) {
            (Some(r), ..) => centre_of_radius(s, e, r, arc.left)?,
            (None, None, None) => return Err((0, Reason::ArcWords)),
            (None, Some(a), Some(b)) if modal.now.centre_is_absolute => Vector::new(a, b),
            (None, ..) if modal.now.centre_is_absolute => return Err((0, Reason::ArcWords)),
            (None, a, b) => s + Vector::new(a.unwrap_or(0.0), b.unwrap_or(0.0)),
        };
        let (a, b) = (s - centre, e - centre);
        let turn = libm::atan2(a.cross(b), a.dot(b));
        let turn = if arc.left { turn } else { -turn };
        let turn = if turn <= 1e-12 { turn + TAU } else { turn } + arc.turns;
        let radii = [a.length(), b.length()];
        if radii.iter().any(|r| *r < 1e-6) {
            return Err((0, Reason::ArcWords));
        }
        Ok(Self {
            axes,
            centre: [centre.x, centre.y],
            from: libm::atan2(a.y, a.x),
            sweep: if arc.left { turn } else { -turn },
            radii,
            across: [on(start, across), on(stop, across)],
        })
    }

    /// Returns the number of lines that stay within the tolerance when lengths grow by `scale`.
    pub(super) fn count(&self, scale: f64, tolerance: f64) -> Result<usize, Failure> {
        let [a, b] = self.radii;
        let step = 2.0 * libm::acos((1.0 - tolerance / (a.max(b) * scale)).max(0.0));
        let count = libm::ceil(fabs(self.sweep) / step).max(1.0);
        let count = if fabs(self.sweep) > PI { count.max(3.0) } else { count };
        if !matches!(count.partial_cmp(&MAX_CHORDS), Some(core::cmp::Ordering::Less)) {
            return Err((0, Reason::TooLong));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        Ok(count as usize)
    }

    /// Returns the point at a part of the way.
    pub(super) fn point(&self, part: f64) -> [f64; 3] {
        let between = |[a, b]: [f64; 2]| a + (b - a) * part;
        let (s, c) = libm::sincos(self.from + self.sweep * part);
        let radius = between(self.radii);
        let [first, second] = self.centre;
        let mut out = [0.0; 3];
        let values = [first + radius * c, second + radius * s, between(self.across)];
        for (axis, value) in self.axes.iter().zip(values) {
            if let Some(to) = out.get_mut(*axis) {
                *to = value;
            }
        }
        out
    }
}

/// Returns the centre of an arc by its radius; a negative one means the long way round.
fn centre_of_radius(s: Vector, e: Vector, r: f64, left: bool) -> Result<Vector, Failure> {
    let chord = e - s;
    let half = chord.length() / 2.0;
    if half < 1e-9 {
        return Err((0, Reason::ArcWords));
    }
    let height = sqrt((r * r - half * half).max(0.0));
    let height = if left == (r > 0.0) { height } else { -height };
    let across = Vector::new(-chord.y, chord.x) * (0.5 / half);
    Ok(s + chord * 0.5 + across * height)
}
