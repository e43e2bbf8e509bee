//! The place of a part from marks, without HAL.
//!
//! | module | subject |
//! |---|---|
//! | [`Transform`] | from points of the file to points of the machine, with its parts: turn, scales, squareness, shift |
//! | [`fit`](fit()) | the transform that brings marks of the file nearest to measured marks |
//! | [`Alignment`] | marks, model and tolerances as an INI file |
//! | `rewrite` | G-code in machine coordinates, with everything else byte for byte |
#![forbid(unsafe_code)]

mod file;
mod fit;
mod matrix;
pub mod rewrite;
mod transform;

pub use file::{Alignment, FileProblem};
pub use fit::{Conditions, Fit, MAX_MARKS, Mark, Misfit, Model, fit};
pub use matrix::{Matrix, Vector};
pub use transform::{Parts, Transform, Warning};
