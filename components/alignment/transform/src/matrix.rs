//! Vectors and matrices of the plane.

use core::{
    fmt,
    ops::{Add, Mul, Sub},
};

/// A point or a direction in the plane, in millimetres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector {
    /// Along X.
    pub x: f64,
    /// Along Y.
    pub y: f64,
}

impl Vector {
    /// The origin.
    pub const ZERO: Self = Self::new(0.0, 0.0);

    /// Returns the vector with these coordinates.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// Returns its length.
    #[must_use]
    pub fn length(self) -> f64 {
        libm::hypot(self.x, self.y)
    }

    /// Returns the scalar product with another vector.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// Returns the Z coordinate of the vector product with another vector.
    #[must_use]
    pub fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Returns whether both coordinates are finite, and small enough to compute with.
    #[must_use]
    pub fn is_usable(self) -> bool {
        libm::fabs(self.x) < 1e9 && libm::fabs(self.y) < 1e9
    }
}

impl fmt::Display for Vector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Never -0.
        let plain = |v: f64| libm::round(v * 1e4) / 1e4 + 0.0;
        write!(f, "X {:.4} Y {:.4}", plain(self.x), plain(self.y))
    }
}

impl Add for Vector {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y)
    }
}

impl Sub for Vector {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y)
    }
}

impl Mul<f64> for Vector {
    type Output = Self;
    fn mul(self, by: f64) -> Self {
        Self::new(self.x * by, self.y * by)
    }
}

/// A linear map of the plane, by its rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix {
    /// From X to X.
    pub m11: f64,
    /// From Y to X.
    pub m12: f64,
    /// From X to Y.
    pub m21: f64,
    /// From Y to Y.
    pub m22: f64,
}

impl Matrix {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self::new(1.0, 0.0, 0.0, 1.0);

    /// Returns the matrix with these rows.
    #[must_use]
    pub const fn new(m11: f64, m12: f64, m21: f64, m22: f64) -> Self {
        Self { m11, m12, m21, m22 }
    }

    /// Returns the rotation by an angle in radians, counterclockwise.
    #[must_use]
    pub fn rotation(angle: f64) -> Self {
        let (s, c) = libm::sincos(angle);
        Self::new(c, -s, s, c)
    }

    /// Returns the factor by which areas grow; negative if the map mirrors.
    #[must_use]
    pub fn det(self) -> f64 {
        self.m11 * self.m22 - self.m12 * self.m21
    }

    /// Returns the inverse map, if there is one.
    #[must_use]
    pub fn inverse(self) -> Option<Self> {
        let det = self.det();
        let inverse = Self::new(self.m22 / det, -self.m12 / det, -self.m21 / det, self.m11 / det);
        inverse.is_usable().then_some(inverse)
    }

    /// Returns the larger and the smaller singular value: the greatest and the least factor of a length.
    #[must_use]
    pub fn stretches(self) -> (f64, f64) {
        let sum = libm::hypot(self.m11 + self.m22, self.m21 - self.m12);
        let difference = libm::hypot(self.m11 - self.m22, self.m21 + self.m12);
        ((sum + difference) / 2.0, libm::fabs(sum - difference) / 2.0)
    }

    /// Returns whether all entries are finite, and small enough to compute with.
    #[must_use]
    pub fn is_usable(self) -> bool {
        [self.m11, self.m12, self.m21, self.m22].iter().all(|x| libm::fabs(*x) < 1e9)
    }
}

impl Mul<Vector> for Matrix {
    type Output = Vector;
    fn mul(self, v: Vector) -> Vector {
        Vector::new(self.m11 * v.x + self.m12 * v.y, self.m21 * v.x + self.m22 * v.y)
    }
}

impl Mul for Matrix {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self::new(
            self.m11 * o.m11 + self.m12 * o.m21,
            self.m11 * o.m12 + self.m12 * o.m22,
            self.m21 * o.m11 + self.m22 * o.m21,
            self.m21 * o.m12 + self.m22 * o.m22,
        )
    }
}
