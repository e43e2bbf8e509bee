//! The transform from the file to the machine.

use crate::{Matrix, Vector};
use core::fmt;
use libm::{atan2, fabs, hypot};

/// Largest deviation of a scale from 1 without a warning.
const USUAL_SCALE: f64 = 0.05;
/// Largest squareness error without a warning, in degrees.
const USUAL_SHEAR: f64 = 2.0;
/// Largest turn without a warning, in degrees.
const USUAL_TURN: f64 = 45.0;
/// Largest relative difference of the scales that counts as none.
const EVEN: f64 = 1e-9;

/// Map from points of the file to points of the machine: `linear · p + shift`, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Turn, scales and squareness.
    pub linear: Matrix,
    /// Place of the file's origin on the machine.
    pub shift: Vector,
}

/// Parts of a transform: scales first, then the turn, then the shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Turn in degrees, counterclockwise.
    pub turn: f64,
    /// Scale along the file's X.
    pub scale_x: f64,
    /// Scale along the file's Y; negative if the part is mirrored.
    pub scale_y: f64,
    /// Squareness error in degrees: the angle by which the part's Y axis leans towards its X axis.
    pub shear: f64,
    /// Place of the file's origin on the machine, in millimetres.
    pub shift: Vector,
}

/// Doubt about a transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Warning {
    /// A scale far from 1.
    Scale(f64),
    /// A large squareness error, in degrees.
    Shear(f64),
    /// A large turn, in degrees.
    Turn(f64),
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scale(s) => write!(f, "a scale of {s:.4} is more than 5 % from 1"),
            Self::Shear(k) => write!(f, "a squareness error of {k:.3} degrees is more than 2"),
            Self::Turn(t) => write!(f, "a turn of {t:.3} degrees is more than 45"),
        }
    }
}

impl Transform {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self { linear: Matrix::IDENTITY, shift: Vector::ZERO };

    /// Returns the point of the machine for a point of the file.
    #[must_use]
    pub fn apply(&self, point: Vector) -> Vector {
        self.linear * point + self.shift
    }

    /// Returns the transform from the machine to the file, if there is one.
    #[must_use]
    pub fn inverse(&self) -> Option<Self> {
        let linear = self.linear.inverse()?;
        let shift = linear * self.shift;
        Some(Self { linear, shift: Vector::ZERO - shift })
    }

    /// Returns the transform with these parts.
    #[must_use]
    pub fn from_parts(parts: &Parts) -> Self {
        let shear = libm::tan(parts.shear.to_radians());
        let upright = Matrix::new(parts.scale_x, parts.scale_y * shear, 0.0, parts.scale_y);
        let linear = Matrix::rotation(parts.turn.to_radians()) * upright;
        Self { linear, shift: parts.shift }
    }

    /// Returns its parts.
    #[must_use]
    pub fn parts(&self) -> Parts {
        let Matrix { m11, m12, m21, m22 } = self.linear;
        let det = self.linear.det();
        let scale_x = hypot(m11, m21);
        let lean = m11 * m12 + m21 * m22;
        let lean = if det < 0.0 { -lean } else { lean };
        Parts {
            turn: atan2(m21, m11).to_degrees(),
            scale_x,
            scale_y: det / scale_x,
            // Never -0.
            shear: atan2(lean, fabs(det)).to_degrees() + 0.0,
            shift: self.shift,
        }
    }

    /// Returns whether circles stay circles.
    #[must_use]
    pub fn is_even(&self) -> bool {
        let (larger, smaller) = self.linear.stretches();
        larger - smaller <= EVEN * larger
    }

    /// Returns doubts about it.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let parts = self.parts();
        let mut out = Vec::new();
        let scale_y = fabs(parts.scale_y);
        for scale in [parts.scale_x, scale_y] {
            if fabs(scale - 1.0) > USUAL_SCALE {
                out.push(Warning::Scale(scale));
            }
        }
        if fabs(parts.shear) > USUAL_SHEAR {
            out.push(Warning::Shear(parts.shear));
        }
        if fabs(parts.turn) > USUAL_TURN {
            out.push(Warning::Turn(parts.turn));
        }
        out
    }
}

impl fmt::Display for Parts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "turn {:.5} deg, scale X {:.6}, scale Y {:.6}, squareness {:.4} deg, shift {} mm",
            self.turn, self.scale_x, self.scale_y, self.shear, self.shift
        )
    }
}
