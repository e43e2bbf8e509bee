//! Checked moves as curves, and the tolerances around them.

use crate::{
    curve::Curve,
    moves::Mode,
    pose::{Group, Pose},
};

/// A checked move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    pub(crate) curve: Curve,
    /// Length in the path coordinate.
    pub(crate) length: f64,
    /// Group that governs the feed.
    pub(crate) lead: Group,
    /// Group in which places on the path are compared.
    pub(crate) main: Group,
    /// Highest speed of the lead group, at a speed of 1 along the path.
    pub(crate) lead_speed: f64,
    /// Programmed feed in units of the lead group per second.
    pub(crate) feed: f64,
    /// Speed in the same units for which its corners are rounded, at most the feed.
    pub(crate) rounded_for: f64,
    /// True for a rapid move.
    pub(crate) rapid: bool,
    pub(crate) mode: Mode,
    pub(crate) line: u32,
    /// True if the start continues the segment before with the same first two derivatives.
    pub(crate) smooth: bool,
    /// Share of the tolerance that the curve itself uses.
    pub(crate) off: f64,
}

impl Segment {
    /// Returns the highest speed of the lead group on another curve of the same groups, at a speed of 1 along it.
    pub(crate) fn lead_speed_on(&self, curve: &Curve, length: f64) -> f64 {
        if self.lead == self.main { 1.0 } else { curve.bounds(0.0, length, self.lead).speed }
    }
}

/// Allowed distance from the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tolerances {
    /// In XYZ and in UVW each.
    pub(crate) linear: f64,
    /// In ABC.
    pub(crate) angular: f64,
}

/// Tolerance of a path without one (G64 without P); half of each segment bounds its blends.
pub(crate) const UNBOUNDED: f64 = 1e6;

impl Tolerances {
    /// Returns true if a tolerance bounds the distance in XYZ.
    pub(crate) const fn is_bounded(&self) -> bool {
        self.linear < 0.5 * UNBOUNDED
    }

    /// Returns the tolerance of a group.
    pub(crate) const fn of(&self, group: Group) -> f64 {
        match group {
            Group::Abc => self.angular,
            Group::Xyz | Group::Uvw => self.linear,
        }
    }

    /// Returns the largest ratio of a displacement to the tolerance of its group.
    pub(crate) fn ratio(&self, by: &Pose) -> f64 {
        self.ratios([*by])
    }

    /// Returns the largest ratio of displacements to the tolerances of their groups.
    pub(crate) fn ratios(&self, all: impl IntoIterator<Item = Pose>) -> f64 {
        let mut squares = [0.0; 3];
        for by in all {
            for (square, group) in squares.iter_mut().zip(Group::ALL) {
                *square = larger(*square, by.dot(&by, group));
            }
        }
        let each = squares.iter().zip(Group::ALL);
        each.map(|(square, group)| square.sqrt() / self.of(group)).fold(0.0, larger)
    }
}

/// Returns the larger of two ratios. One that is not a number counts as infinity, so that nothing is inside a tolerance
/// because it cannot be compared.
pub(crate) const fn larger(a: f64, b: f64) -> f64 {
    if b <= a {
        a
    } else if a < b {
        b
    } else {
        f64::INFINITY
    }
}
