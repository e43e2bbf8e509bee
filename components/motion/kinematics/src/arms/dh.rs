//! Realtime. Arms of six revolute joints, described by Denavit-Hartenberg parameters.
//!
//! Denavit and Hartenberg, A kinematic notation for lower-pair mechanisms (1955), in the form of Craig, Introduction to
//! Robotics, section 3.4: frame i is attached to the axis of joint i.

use crate::rotation::{Matrix, Vector, about_x, about_z};
use libm::fabs;
use nalgebra::{Matrix6, Vector6};

/// Position of one joint axis relative to the previous one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    /// Distance between the axes, in units.
    pub(crate) a: f64,
    /// Twist angle between the axes, in radians.
    pub(crate) alpha: f64,
    /// Offset along the axis, in units.
    pub(crate) d: f64,
}

/// Six-link chain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chain(pub(crate) [Link; 6]);

impl Chain {
    /// Returns position and orientation of the last frame. Angles are in radians.
    pub(crate) fn end(&self, angles: &[f64; 6]) -> (Vector, Matrix) {
        let mut frame = (Vector::zeros(), Matrix::identity());
        for (link, angle) in self.0.iter().zip(angles) {
            frame = next(&frame, link, *angle);
        }
        frame
    }

    /// Returns the geometric Jacobian, which maps joint rates to the motion of the end (Craig, section 5.8).
    pub(crate) fn jacobian(&self, angles: &[f64; 6]) -> Matrix6<f64> {
        let (end, _) = self.end(angles);
        let mut frame = (Vector::zeros(), Matrix::identity());
        let mut out = Matrix6::zeros();
        for ((link, angle), mut column) in self.0.iter().zip(angles).zip(out.column_iter_mut()) {
            frame = next(&frame, link, *angle);
            let axis = frame.1 * Vector::z();
            let way = axis.cross(&(end - frame.0));
            column.copy_from(&Vector6::new(way.x, way.y, way.z, axis.x, axis.y, axis.z));
        }
        out
    }

    /// Returns an upper bound of the distance between the base and any point of the arm, in units.
    pub(crate) fn reach(&self) -> f64 {
        self.0.iter().map(|l| fabs(l.a) + fabs(l.d)).sum()
    }
}

fn next((place, turned): &(Vector, Matrix), link: &Link, angle: f64) -> (Vector, Matrix) {
    let tilt = about_x(link.alpha);
    let step = Vector::new(link.a, 0.0, 0.0) + tilt * Vector::new(0.0, 0.0, link.d);
    (place + turned * step, turned * tilt * about_z(angle))
}
