//! Realtime. Poses in nine axes, and their arithmetic.

use core::ops::{Add, Mul, Neg, Sub};

/// Number of axes: X Y Z A B C U V W.
pub const AXES: usize = 9;

/// Largest coordinate, in units.
pub const FARTHEST: f64 = 1e9;

/// A pose, or a derivative of one: X Y Z A B C U V W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose(pub [f64; AXES]);

/// Axes that share a unit and a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// X Y Z, in length units.
    Xyz,
    /// A B C, in degrees.
    Abc,
    /// U V W, in length units.
    Uvw,
}

impl Group {
    /// Every group.
    pub const ALL: [Self; 3] = [Self::Xyz, Self::Abc, Self::Uvw];
}

impl Pose {
    /// The pose with every axis at 0.
    pub const ZERO: Self = Self([0.0; AXES]);

    /// Returns the values of three axes.
    #[inline]
    pub const fn group(&self, group: Group) -> [f64; 3] {
        let [x, y, z, a, b, c, u, v, w] = self.0;
        match group {
            Group::Xyz => [x, y, z],
            Group::Abc => [a, b, c],
            Group::Uvw => [u, v, w],
        }
    }

    /// Returns the scalar product of two poses in a group.
    #[inline]
    pub const fn dot(&self, other: &Self, group: Group) -> f64 {
        let ([a, b, c], [x, y, z]) = (self.group(group), other.group(group));
        a * x + b * y + c * z
    }

    /// Returns the Euclidean length in a group.
    #[inline]
    pub fn norm(&self, group: Group) -> f64 {
        self.dot(self, group).sqrt()
    }

    /// Returns the scalar product over all axes.
    #[inline]
    pub fn dot_all(&self, other: &Self) -> f64 {
        let [x, y, z] = Group::ALL.map(|g| self.dot(other, g));
        x + y + z
    }

    /// Returns the absolute values.
    #[inline]
    #[must_use]
    pub fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    /// Returns the larger value of each axis.
    #[inline]
    #[must_use]
    pub fn max(self, other: &Self) -> Self {
        self.with(other, |x, y| if x > y { x } else { y })
    }

    /// Combines the values of each axis. The loop has no branches and no calls, so that it becomes vector instructions.
    #[inline(always)]
    fn with(mut self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for (x, y) in self.0.iter_mut().zip(&other.0) {
            *x = f(*x, *y);
        }
        self
    }

    /// Returns true if every value is a number within the largest coordinate.
    pub fn is_usable(&self) -> bool {
        self.0.iter().all(|x| x.abs() <= FARTHEST)
    }

    /// Pose that moves in XYZ only.
    pub const fn from_xyz(v: [f64; 3]) -> Self {
        Self([v[0], v[1], v[2], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }
}

impl Add for Pose {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(&other, |x, y| x + y)
    }
}

impl Sub for Pose {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(&other, |x, y| x - y)
    }
}

impl Mul<f64> for Pose {
    type Output = Self;

    #[inline(always)]
    fn mul(self, k: f64) -> Self {
        Self(self.0.map(|x| x * k))
    }
}

impl Neg for Pose {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}
