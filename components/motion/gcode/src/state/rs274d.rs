//! The values of a program in RS274-D that the modal state has no place for.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::{
    axis::Position,
    canon::{PathMode, Unit},
};

/// The values of a program in RS274-D beyond the modal ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rs274d {
    /// The values before the program, from its begin to the end of its job.
    pub before: Option<Box<Before>>,
    /// The point that the last G28 went through, in machine coordinates of millimetres.
    pub via: Option<Position>,
    /// Warnings that the operator has seen, each given once.
    pub warned: BTreeSet<Box<str>>,
}

/// Values that a program in RS274-D replaces, and that return at its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Before {
    /// The offset of G92 in millimetres.
    pub g92: Position,
    /// The unit of length (G20, G21).
    pub unit: Unit,
    /// The path mode (G61, G61.1, G64) with its tolerance of short lines.
    pub path: PathMode,
    /// As G64's Q.
    pub naive_tolerance: f64,
    /// True for absolute distances (G90).
    pub absolute: bool,
    /// True for absolute centres of arcs (G90.1).
    pub ijk_absolute: bool,
    /// True for diameters (G7).
    pub diameter: bool,
}
