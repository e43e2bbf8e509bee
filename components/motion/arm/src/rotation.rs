//! Realtime. Rotations, in degrees where users see them.
//!
//! Sine and cosine come from `libm`, so that results are the same on every machine; matrices are nalgebra's.

use core::f64::consts::PI;
use libm::{atan2, cos, fabs, hypot, remainder, sin};
use nalgebra::{Matrix3, Vector3};

/// Column of three numbers.
pub type Vector = Vector3<f64>;
/// Matrix of three rows and columns.
pub type Matrix = Matrix3<f64>;

/// Returns the rotation about the X axis by an angle in radians.
#[must_use]
pub fn about_x(angle: f64) -> Matrix {
    let (s, c) = (sin(angle), cos(angle));
    Matrix::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

/// Returns the rotation about the Y axis by an angle in radians.
#[must_use]
pub fn about_y(angle: f64) -> Matrix {
    let (s, c) = (sin(angle), cos(angle));
    Matrix::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

/// Returns the rotation about the Z axis by an angle in radians.
#[must_use]
pub fn about_z(angle: f64) -> Matrix {
    let (s, c) = (sin(angle), cos(angle));
    Matrix::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

/// Returns the rotation about a unit vector by an angle in radians (Rodrigues' formula; Craig, Introduction to
/// Robotics, section 2.8).
#[must_use]
pub fn about(axis: &Vector, angle: f64) -> Matrix {
    let k = axis.cross_matrix();
    Matrix::identity() + k * sin(angle) + k * k * (1.0 - cos(angle))
}

/// Returns the rotation of roll A, pitch B and yaw C in degrees: about the fixed axes X, then Y, then Z (Craig, section
/// 2.8).
#[must_use]
pub fn from_abc([a, b, c]: [f64; 3]) -> Matrix {
    about_z(c.to_radians()) * about_y(b.to_radians()) * about_x(a.to_radians())
}

/// Returns roll, pitch and yaw of a rotation in degrees. At a pitch of ±90 degrees, only the sum or the difference of
/// roll and yaw is determined; yaw then stays at `last_yaw`.
#[must_use]
pub fn to_abc(m: &Matrix, last_yaw: f64) -> [f64; 3] {
    let level = hypot(m[(0, 0)], m[(1, 0)]);
    let b = atan2(-m[(2, 0)], level);
    if level > UPRIGHT {
        let a = atan2(m[(2, 1)], m[(2, 2)]);
        let c = atan2(m[(1, 0)], m[(0, 0)]);
        return [a, b, c].map(f64::to_degrees);
    }
    let rest = about_z(-last_yaw.to_radians()) * m;
    let a = atan2(-rest.m23, rest.m22);
    [a.to_degrees(), b.to_degrees(), last_yaw]
}

/// Cosine of pitch below which the pitch counts as ±90 degrees.
const UPRIGHT: f64 = 1e-12;

/// Returns the rotation vector: the axis, with the angle in radians as its length.
#[must_use]
pub fn to_vector(m: &Matrix) -> Vector {
    let twice = Vector::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]);
    let sine = twice.norm() / 2.0;
    let cosine = (m.trace() - 1.0) / 2.0;
    let angle = atan2(sine, cosine);
    if sine > 1e-9 {
        return twice * (angle / (2.0 * sine));
    }
    if cosine > 0.0 {
        return twice / 2.0;
    }
    // Half a turn: each column of m + 1 is parallel to the axis.
    let half = m + Matrix::identity();
    let mut axis = Vector::x();
    let mut longest = 0.0;
    for column in half.column_iter() {
        let length = column.norm();
        if length > longest {
            longest = length;
            axis = column / length;
        }
    }
    axis * angle
}

/// Returns the angle in degrees that differs from the given one by full turns and is nearest to `last`.
#[must_use]
pub fn near(angle: f64, last: f64) -> f64 {
    last + remainder(angle - last, 360.0)
}

/// Returns whether a sine is so close to 0 that the configuration is straight, and so singular.
#[must_use]
pub fn is_straight(sine: f64) -> bool {
    fabs(sine) < SINGULAR
}

/// Sine below which an angle counts as singular: the joints would move a million times as far as the tool.
const SINGULAR: f64 = 1e-6;

/// Returns the angles of a rotation in degrees about Z, the new Y and the new Z. The first is 0 where only the sum or the
/// difference of the outer two is determined.
#[must_use]
pub fn to_zyz(m: &Matrix) -> [f64; 3] {
    let s = hypot(m[(2, 0)], m[(2, 1)]);
    let angles = if s > UPRIGHT_ZYZ {
        [atan2(m[(1, 2)], m[(0, 2)]), atan2(s, m[(2, 2)]), atan2(m[(2, 1)], -m[(2, 0)])]
    } else if m[(2, 2)] > 0.0 {
        [0.0, 0.0, atan2(-m[(0, 1)], m[(0, 0)])]
    } else {
        [0.0, PI, atan2(m[(0, 1)], -m[(0, 0)])]
    };
    angles.map(f64::to_degrees)
}

/// Returns the rotation by angles in degrees about Z, the new Y and the new Z.
#[must_use]
pub fn from_zyz([a, b, c]: [f64; 3]) -> Matrix {
    about_z(a.to_radians()) * about_y(b.to_radians()) * about_z(c.to_radians())
}

/// Sine of the middle angle below which the outer two are not determined.
const UPRIGHT_ZYZ: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zyz_comes_back() {
        for (given, expected) in [
            ([30.0, 20.0, -10.0], [30.0, 20.0, -10.0]),
            ([-150.0, 160.0, 31.5666], [-150.0, 160.0, 31.5666]),
            ([10.0, 0.0, 20.0], [0.0, 0.0, 30.0]),
            ([10.0, 180.0, 20.0], [0.0, 180.0, 10.0]),
        ] {
            let found = to_zyz(&from_zyz(given));
            assert!(found.iter().zip(expected).all(|(a, b)| fabs(a - b) < 1e-9), "{found:?}");
        }
        for n in 0..1000 {
            let angle = |k: f64| 360.0 * (f64::from(n) * k).fract() - 180.0;
            let m = from_abc([angle(0.618), angle(0.755), angle(0.569)]);
            assert!((from_zyz(to_zyz(&m)) - m).amax() < 1e-12);
        }
    }
}
