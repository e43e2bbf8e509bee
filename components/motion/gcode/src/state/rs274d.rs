//! The values of a program in RS274-D that the modal state has no place for.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::axis::Position;

/// The values of a program in RS274-D beyond the modal ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rs274d {
    /// The program has begun: the start values are in force.
    pub begun: bool,
    /// The offset of G92 before the program, in millimetres; it returns at the end.
    pub g92: Position,
    /// The point that the last G28 went through, in machine coordinates of millimetres.
    pub via: Option<Position>,
    /// Warnings that the operator has seen, each given once.
    pub warned: BTreeSet<Box<str>>,
}
