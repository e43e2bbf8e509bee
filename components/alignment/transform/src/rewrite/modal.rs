//! Modes and position of a program, as far as alignment depends on them.

use crate::Vector;
use std::collections::BTreeSet;

/// Motion in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// Unknown: at the begin, and behind flow control.
    Unknown,
    /// G80.
    None,
    /// G0, G1, G33, G33.1.
    Line,
    /// G38.2 to G38.5.
    Probe,
    /// G2; true for G3.
    Arc(bool),
    /// G73 to G89.
    Cycle,
    /// Splines, threads and others that are refused, in tenths.
    Other(i32),
}

/// Plane of arcs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ArcPlane {
    /// G17.
    Xy,
    /// G18.
    Zx,
    /// G19.
    Yz,
    /// G17.1 to G19.1.
    Other,
}

/// Modes that decide how coordinates are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Modes {
    pub(super) plane: ArcPlane,
    pub(super) inches: bool,
    pub(super) incremental: bool,
    pub(super) centre_is_absolute: bool,
}

impl Modes {
    /// Returns the millimetres of a unit.
    pub(super) const fn unit(self) -> f64 {
        if self.inches { 25.4 } else { 1.0 }
    }
}

/// State of a program.
#[derive(Clone, Debug)]
pub(super) struct Modal {
    pub(super) now: Modes,
    pub(super) motion: Motion,
    /// Motion that the result has in force, if it differs from that of the source.
    pub(super) written: Option<Motion>,
    pub(super) inverse_time: bool,
    /// The program has had G93.
    pub(super) any_inverse_time: bool,
    /// The tool's radius is compensated (G41, G42).
    pub(super) compensated: bool,
    /// Position in the file, in millimetres.
    pub(super) x: Option<f64>,
    pub(super) y: Option<f64>,
    pub(super) z: Option<f64>,
    /// Exact machine position less the written one, in millimetres.
    pub(super) carry: Vector,
    /// Coordinate system, in tenths of its G code.
    pub(super) system: Option<i32>,
    /// Modes under which blocks were rewritten; with flow control also those at O-words.
    pub(super) modes: BTreeSet<Modes>,
    pub(super) has_feed: bool,
    /// The program has given its unit.
    pub(super) has_unit: bool,
    /// Blocks were rewritten before that.
    pub(super) unit_is_assumed: bool,
    pub(super) ended: bool,
}

impl Modal {
    /// Returns the state before the first line.
    pub(super) fn new(start: Option<Vector>, inches: bool) -> Self {
        Self {
            now: Modes {
                plane: ArcPlane::Xy,
                inches,
                incremental: false,
                centre_is_absolute: false,
            },
            motion: Motion::Unknown,
            written: None,
            inverse_time: false,
            any_inverse_time: false,
            compensated: false,
            x: start.map(|s| s.x),
            y: start.map(|s| s.y),
            z: None,
            carry: Vector::ZERO,
            system: None,
            modes: BTreeSet::new(),
            has_feed: false,
            has_unit: false,
            unit_is_assumed: false,
            ended: false,
        }
    }

    /// Forgets the position.
    pub(super) fn forget_position(&mut self) {
        (self.x, self.y, self.z) = (None, None, None);
        self.carry = Vector::ZERO;
    }

    /// Forgets what flow control makes unknown.
    pub(super) fn forget_all(&mut self) {
        self.forget_position();
        self.motion = Motion::Unknown;
        self.written = None;
    }

    /// Notes that a block was rewritten.
    pub(super) fn rewrote(&mut self) {
        self.modes.insert(self.now);
        self.unit_is_assumed |= !self.has_unit;
    }

    /// Returns the place in X and Y, if both are known.
    pub(super) fn place(&self) -> Option<Vector> {
        Some(Vector::new(self.x?, self.y?))
    }
}
