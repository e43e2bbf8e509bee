//! Place of a part: the frame that brings designed points nearest to touched points.

use crate::{
    frame::Frame,
    rotation::{Matrix, Vector},
};
use libm::{atan2, fabs, sqrt};
use std::fmt;

/// Largest number of pairs.
pub const MAX_PAIRS: usize = 1000;
/// Smallest distance of a point from the line through the two that are farthest apart, in millimetres.
const OFF_LINE: f64 = 1.0;
/// Smallest angle at which the line through two points is seen from a third, in degrees.
const ANGLE: f64 = 5.0;
/// Difference of a distance between the two sets above which there is a warning, in millimetres.
const WARNED: f64 = 0.5;
/// Difference above which the sets do not match, in millimetres.
const REFUSED: f64 = 5.0;

/// Place of a part by least squares (Arun, Huang and Blostein, Least-squares fitting of two 3-D point sets, 1987).
#[derive(Clone, PartialEq, Debug)]
pub struct Fit {
    /// Frame of the design relative to the arm's base.
    pub frame: Frame,
    /// Distance of each touched point from the designed point in its place, in millimetres.
    pub residuals: Vec<f64>,
    /// Pairs of points whose distance differs noticeably between the two sets: their numbers, and the difference.
    pub differences: Vec<(usize, usize, f64)>,
}

/// Reason why points give no frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Misfit {
    /// There are fewer than three pairs, or too many.
    Count(usize),
    /// The two sets have different sizes.
    Unequal(usize, usize),
    /// A coordinate is not finite.
    NoNumber,
    /// The points of a set lie on a line; true for the touched ones.
    Collinear(bool),
    /// The distance of two points differs between the sets: their numbers from 1, and the difference.
    Mismatched(usize, usize, f64),
    /// A point is far from its place: its number from 1, and the distance.
    Residual(usize, f64),
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(n) => write!(f, "{n} points: between 3 and {MAX_PAIRS} are needed"),
            Self::Unequal(a, b) => write!(f, "{a} designed and {b} touched points"),
            Self::NoNumber => f.write_str("a coordinate is not finite"),
            Self::Collinear(true) => f.write_str("the touched points lie on a line"),
            Self::Collinear(false) => f.write_str("the designed points lie on a line"),
            Self::Mismatched(a, b, by) => write!(
                f,
                "the distance of points {a} and {b} is {by:+.3} mm different from the design's"
            ),
            Self::Residual(n, by) => write!(f, "touched point {n} is {by:.3} mm off its place"),
        }
    }
}

impl Fit {
    /// Returns the greatest distance of a touched point from its place.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.residuals.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the root of the mean square of the residuals.
    #[must_use]
    pub fn rms(&self) -> f64 {
        let sum: f64 = self.residuals.iter().map(|r| r * r).sum();
        sqrt(sum / self.residuals.len().max(1) as f64)
    }
}

/// Returns the frame that brings designed points to the touched points of the same numbers.
///
/// # Errors
/// The points do not determine a frame, or do not match.
pub fn fit(design: &[Vector], touched: &[Vector]) -> Result<Fit, Misfit> {
    if design.len() != touched.len() {
        return Err(Misfit::Unequal(design.len(), touched.len()));
    }
    if !(3..=MAX_PAIRS).contains(&design.len()) {
        return Err(Misfit::Count(design.len()));
    }
    let is_number = |p: &Vector| p.iter().all(|x| fabs(*x) < 1e9);
    if !design.iter().chain(touched).all(is_number) {
        return Err(Misfit::NoNumber);
    }
    for (points, is_touched) in [(design, false), (touched, true)] {
        if is_collinear(points) {
            return Err(Misfit::Collinear(is_touched));
        }
    }
    let pairs: Vec<_> = (1..).zip(design.iter().zip(touched)).collect();
    let mut differences = Vec::new();
    for (n, (i, (a, p))) in pairs.iter().enumerate() {
        for (j, (b, q)) in pairs.iter().skip(n + 1) {
            let by = (*p - *q).norm() - (*a - *b).norm();
            if fabs(by) > REFUSED {
                return Err(Misfit::Mismatched(*i, *j, by));
            }
            if fabs(by) > WARNED {
                differences.push((*i, *j, by));
            }
        }
    }
    let mean = |points: &[Vector]| points.iter().sum::<Vector>() / points.len() as f64;
    let (from, to) = (mean(design), mean(touched));
    let spread: Matrix =
        design.iter().zip(touched).map(|(d, t)| (t - to) * (d - from).transpose()).sum();
    let turn = rotation(&spread).ok_or(Misfit::Collinear(true))?;
    let frame = Frame { origin: to - turn * from, turn };
    let residuals: Vec<f64> =
        design.iter().zip(touched).map(|(d, t)| (t - frame.point(d)).norm()).collect();
    let far = (1..).zip(&residuals).find(|(_, r)| **r > REFUSED);
    if let Some((n, by)) = far {
        return Err(Misfit::Residual(n, *by));
    }
    Ok(Fit { frame, residuals, differences })
}

/// Returns the rotation nearest to a matrix; mirrored solutions do not count.
fn rotation(spread: &Matrix) -> Option<Matrix> {
    let svd = spread.svd(true, true);
    let (u, v) = (svd.u?, svd.v_t?);
    let sign = if (u * v).determinant() < 0.0 { -1.0 } else { 1.0 };
    // The least singular value is the last.
    Some(u * Matrix::from_diagonal(&Vector::new(1.0, 1.0, sign)) * v)
}

/// Returns whether all points are near the line through the two that are farthest apart.
fn is_collinear(points: &[Vector]) -> bool {
    let mut far = (0.0, Vector::zeros(), Vector::zeros());
    for (n, a) in points.iter().enumerate() {
        for b in points.iter().skip(n + 1) {
            let length = (b - a).norm();
            if length > far.0 {
                far = (length, *a, b - a);
            }
        }
    }
    let (length, from, along) = far;
    let off = points.iter().map(|p| {
        let off = (p - from).cross(&along).norm() / length;
        let nearer = f64::min((p - from).norm(), (p - from - along).norm());
        (off, atan2(off, f64::max(nearer, length - nearer)).to_degrees())
    });
    !off.into_iter().any(|(off, angle)| off >= OFF_LINE && angle >= ANGLE)
}
