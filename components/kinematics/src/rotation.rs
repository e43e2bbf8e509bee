//! Realtime. Rotations, in degrees where users see them.
//!
//! Sine and cosine are `libm`'s, the same on every machine; matrices are nalgebra's.

use libm::{atan2, cos, fabs, hypot, remainder, sin};
use nalgebra::{Matrix3, Vector3};

pub(crate) type Vector = Vector3<f64>;
pub(crate) type Matrix = Matrix3<f64>;

/// About the X axis, by an angle in radians.
pub(crate) fn about_x(angle: f64) -> Matrix {
    let (s, c) = (sin(angle), cos(angle));
    Matrix::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

/// About the Y axis, by an angle in radians.
pub(crate) fn about_y(angle: f64) -> Matrix {
    let (s, c) = (sin(angle), cos(angle));
    Matrix::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

/// About the Z axis, by an angle in radians.
pub(crate) fn about_z(angle: f64) -> Matrix {
    let (s, c) = (sin(angle), cos(angle));
    Matrix::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

/// About a unit vector, by an angle in radians (Rodrigues' formula; Craig, Introduction to
/// Robotics, section 2.8).
pub(crate) fn about(axis: &Vector, angle: f64) -> Matrix {
    let k = axis.cross_matrix();
    Matrix::identity() + k * sin(angle) + k * k * (1.0 - cos(angle))
}

/// From roll A, pitch B and yaw C in degrees: about the fixed axes X, then Y, then Z (Craig,
/// section 2.8).
pub(crate) fn from_abc([a, b, c]: [f64; 3]) -> Matrix {
    about_z(c.to_radians()) * about_y(b.to_radians()) * about_x(a.to_radians())
}

/// Roll, pitch and yaw in degrees. Where pitch is 90 degrees up or down only the sum or the
/// difference of the others is determined; then yaw is what it was.
pub(crate) fn to_abc(m: &Matrix, last_yaw: f64) -> [f64; 3] {
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

/// Cosine of a pitch that counts as 90 degrees.
const UPRIGHT: f64 = 1e-12;

/// The axis of a rotation, as long as its angle in radians.
pub(crate) fn to_vector(m: &Matrix) -> Vector {
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
    // Half a turn: the axis is in the columns of m + 1.
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

/// The angle in degrees, a whole number of turns from the given one, that is nearest to `last`.
pub(crate) fn near(angle: f64, last: f64) -> f64 {
    last + remainder(angle - last, 360.0)
}

/// Whether an angle in radians is one of a straight line, within what counts as singular.
pub(crate) fn is_straight(sine: f64) -> bool {
    fabs(sine) < SINGULAR
}

/// Sine of an angle that counts as singular: the joints would move a million times as far as
/// the tool.
pub(crate) const SINGULAR: f64 = 1e-6;
