//! The nine axes and positions in them.

use core::ops::{Add, Index, IndexMut, Sub};

use serde::{Deserialize, Serialize};

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Axis {
    /// First linear axis.
    X,
    /// Second linear axis.
    Y,
    /// Third linear axis.
    Z,
    /// Rotary axis about X.
    A,
    /// Rotary axis about Y.
    B,
    /// Rotary axis about Z.
    C,
    /// Linear axis parallel to X.
    U,
    /// Linear axis parallel to Y.
    V,
    /// Linear axis parallel to Z.
    W,
}

impl Axis {
    /// All axes in the order of parameters and calls.
    pub const ALL: [Self; 9] =
        [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C, Self::U, Self::V, Self::W];

    /// Returns the place in [`Axis::ALL`].
    pub fn index(self) -> u16 {
        self as u16
    }

    /// Tells whether the axis counts degrees.
    pub fn is_rotary(self) -> bool {
        matches!(self, Self::A | Self::B | Self::C)
    }

    /// Returns the letter in lower case.
    pub fn letter(self) -> char {
        match self {
            Self::X => 'x',
            Self::Y => 'y',
            Self::Z => 'z',
            Self::A => 'a',
            Self::B => 'b',
            Self::C => 'c',
            Self::U => 'u',
            Self::V => 'v',
            Self::W => 'w',
        }
    }
}

/// A set of axes, one bit each, X lowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisMask(pub u16);

impl AxisMask {
    /// All nine axes.
    pub const ALL: Self = Self(0x1ff);
    /// X, Y, Z, A, B and C.
    pub const XYZABC: Self = Self(0x3f);

    /// Tells whether `axis` is in the set.
    pub fn has(self, axis: Axis) -> bool {
        self.0 & (1 << axis.index()) != 0
    }
}

/// A position or offset: lengths in the unit of its context, rotary axes in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// X.
    pub x: f64,
    /// Y.
    pub y: f64,
    /// Z.
    pub z: f64,
    /// A in degrees.
    pub a: f64,
    /// B in degrees.
    pub b: f64,
    /// C in degrees.
    pub c: f64,
    /// U.
    pub u: f64,
    /// V.
    pub v: f64,
    /// W.
    pub w: f64,
}

impl Position {
    /// Returns the position with each coordinate changed by `f`.
    #[must_use]
    pub fn map(mut self, f: impl Fn(Axis, f64) -> f64) -> Self {
        for axis in Axis::ALL {
            self[axis] = f(axis, self[axis]);
        }
        self
    }

    /// Returns the position with its lengths multiplied by `factor`; angles stay.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        self.map(|axis, v| if axis.is_rotary() { v } else { v * factor })
    }

    /// Returns the position turned about Z by `degrees`.
    #[must_use]
    pub fn rotated(mut self, degrees: f64) -> Self {
        if degrees != 0.0 {
            (self.x, self.y) = rotate(self.x, self.y, degrees);
        }
        self
    }

    /// Tells whether every coordinate is finite.
    pub fn is_finite(&self) -> bool {
        Axis::ALL.iter().all(|a| self[*a].is_finite())
    }
}

/// Turns the point `(x, y)` about the origin by `degrees`, counterclockwise.
pub fn rotate(x: f64, y: f64, degrees: f64) -> (f64, f64) {
    let angle = degrees.to_radians();
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    (x * cos - y * sin, x * sin + y * cos)
}

impl Index<Axis> for Position {
    type Output = f64;

    fn index(&self, axis: Axis) -> &f64 {
        match axis {
            Axis::X => &self.x,
            Axis::Y => &self.y,
            Axis::Z => &self.z,
            Axis::A => &self.a,
            Axis::B => &self.b,
            Axis::C => &self.c,
            Axis::U => &self.u,
            Axis::V => &self.v,
            Axis::W => &self.w,
        }
    }
}

impl IndexMut<Axis> for Position {
    fn index_mut(&mut self, axis: Axis) -> &mut f64 {
        match axis {
            Axis::X => &mut self.x,
            Axis::Y => &mut self.y,
            Axis::Z => &mut self.z,
            Axis::A => &mut self.a,
            Axis::B => &mut self.b,
            Axis::C => &mut self.c,
            Axis::U => &mut self.u,
            Axis::V => &mut self.v,
            Axis::W => &mut self.w,
        }
    }
}

impl Add for Position {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.map(|axis, v| v + other[axis])
    }
}

impl Sub for Position {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.map(|axis, v| v - other[axis])
    }
}
