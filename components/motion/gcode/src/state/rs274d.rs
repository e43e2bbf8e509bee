//! The values of a program in RS274-D that the modal state has no place for.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::Modal;
use crate::axis::Position;

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
    /// The modal state, of which the unit, the path mode and the modes of distances return.
    pub modal: Modal,
}
