//! Realtime. Rigid transforms: where a frame lies, and how it is turned.

use crate::rotation::{Matrix, Vector, from_abc};

/// Frame relative to another: its origin, and its axes as columns.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Frame {
    /// Origin, in units.
    pub origin: Vector,
    /// Rotation; its columns are the frame's axes.
    pub turn: Matrix,
}

impl Frame {
    /// Returns the frame that coincides with its reference.
    #[must_use]
    pub fn identity() -> Self {
        Self { origin: Vector::zeros(), turn: Matrix::identity() }
    }

    /// Returns the frame at X Y Z with roll A, pitch B and yaw C in degrees.
    #[must_use]
    pub fn from_xyzabc([x, y, z, a, b, c]: [f64; 6]) -> Self {
        Self { origin: Vector::new(x, y, z), turn: from_abc([a, b, c]) }
    }

    /// Returns a frame given in this one, relative to this one's reference.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self { origin: self.point(&next.origin), turn: self.turn * next.turn }
    }

    /// Returns the reference relative to this frame.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let turn = self.turn.transpose();
        Self { origin: -(turn * self.origin), turn }
    }

    /// Returns a point given in this frame, relative to this one's reference.
    #[must_use]
    pub fn point(&self, p: &Vector) -> Vector {
        self.origin + self.turn * p
    }
}
