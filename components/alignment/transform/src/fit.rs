//! The transform that brings marks of the file nearest to the measured marks.

use crate::{Matrix, Parts, Transform, Vector};
use core::fmt;
use libm::{atan2, fabs, hypot, sqrt};

/// Largest number of marks.
pub const MAX_MARKS: usize = 1000;
/// Smallest distance of two marks, in millimetres.
const APART: f64 = 5.0;
/// Smallest spread of the marks across their longest direction, as a part of the spread along it.
const SPREAD: f64 = 0.05;
/// Largest number of steps of the refinement.
const STEPS: usize = 100;

/// A mark: its place in the file and its measured place on the machine, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Place in the file.
    pub file: Vector,
    /// Measured place on the machine.
    pub machine: Vector,
}

/// Kinds of transforms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// A shift for one mark, a similarity for two, an affine map for three or more.
    #[default]
    Auto,
    /// A shift alone.
    Shift,
    /// Turn and shift.
    Rigid,
    /// Turn, one scale, shift.
    Similarity,
    /// Turn, two scales, shift.
    ScaleXy,
    /// Turn, two scales, squareness, shift.
    Affine,
}

impl Model {
    /// The models by name.
    pub const NAMES: [(&str, Self); 6] = [
        ("auto", Self::Auto),
        ("shift", Self::Shift),
        ("rigid", Self::Rigid),
        ("similarity", Self::Similarity),
        ("scale-xy", Self::ScaleXy),
        ("affine", Self::Affine),
    ];

    /// Returns the model of a name.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|row| row.0 == name).map(|row| row.1)
    }

    /// Returns its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|row| row.1 == self).map_or("auto", |row| row.0)
    }

    /// Returns the model for a number of marks.
    const fn for_marks(self, n: usize) -> Self {
        match (self, n) {
            (Self::Auto, 0 | 1) => Self::Shift,
            (Self::Auto, 2) => Self::Similarity,
            (Self::Auto, _) => Self::Affine,
            (other, _) => other,
        }
    }

    /// Returns the smallest number of marks.
    const fn least(self) -> usize {
        match self {
            Self::Auto | Self::Shift => 1,
            Self::Rigid | Self::Similarity => 2,
            Self::ScaleXy | Self::Affine => 3,
        }
    }
}

/// Conditions of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Kind of the transform.
    pub model: Model,
    /// Largest root of the mean square of the residuals, in millimetres.
    pub tolerance: f64,
    /// True if the part lies on its back, so that it is mirrored.
    pub mirror: bool,
}

impl Default for Conditions {
    fn default() -> Self {
        Self { model: Model::Auto, tolerance: 0.1, mirror: false }
    }
}

/// Transform with its quality.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The transform.
    pub transform: Transform,
    /// The model that was used.
    pub model: Model,
    /// Measured place less computed place of each mark, in millimetres.
    pub residuals: Vec<Vector>,
    /// Root of the mean square of the residuals, in millimetres.
    pub rms: f64,
}

/// Reason why marks give no transform. Marks are numbered from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Misfit {
    /// A number of marks that the model cannot use.
    Count(usize, Model),
    /// A coordinate that is not finite or beyond 1e9 mm.
    NoNumber(usize),
    /// Two marks that are too close; true for the measured ones.
    Close(usize, usize, f64, bool),
    /// Marks on a line; true for the measured ones.
    Collinear(bool),
    /// A mirrored part that was not said to be so.
    Mirrored,
    /// A part that was said to be mirrored and is not.
    NotMirrored,
    /// Residuals above the tolerance: their root mean square, the tolerance, the worst mark and its residual.
    Residual(f64, f64, usize, f64),
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(n, model) => write!(
                f,
                "{n} marks: the model {} needs between {} and {MAX_MARKS}",
                model.name(),
                model.least()
            ),
            Self::NoNumber(n) => write!(f, "mark {n}: a coordinate is not a number below 1e9 mm"),
            Self::Close(a, b, d, measured) => write!(
                f,
                "marks {a} and {b} are {d:.3} mm apart {}: at least {APART} mm are needed",
                if *measured { "as measured" } else { "in the file" }
            ),
            Self::Collinear(measured) => write!(
                f,
                "the marks lie on a line {}: take one beside it, or the model similarity",
                if *measured { "as measured" } else { "in the file" }
            ),
            Self::Mirrored => f.write_str(
                "the part is mirrored: if it lies on its back, say mirror; if not, two marks are exchanged",
            ),
            Self::NotMirrored => f.write_str("the part is not mirrored, though mirror was asked for"),
            Self::Residual(rms, tolerance, worst, by) => write!(
                f,
                "the marks fit to {rms:.4} mm only, and {tolerance} mm are allowed: mark {worst} is the worst, off by {by:.4} mm"
            ),
        }
    }
}

/// Returns the transform that brings the marks of the file nearest to the measured marks (least squares).
///
/// # Errors
/// The marks do not determine the transform, or fit worse than the tolerance.
pub fn fit(marks: &[Mark], options: &Conditions) -> Result<Fit, Misfit> {
    let model = options.model.for_marks(marks.len());
    if marks.len() < model.least() || marks.len() > MAX_MARKS {
        return Err(Misfit::Count(marks.len(), model));
    }
    let is_bad = |m: &Mark| !m.file.is_usable() || !m.machine.is_usable();
    if let Some(n) = marks.iter().position(is_bad) {
        return Err(Misfit::NoNumber(n + 1));
    }
    for measured in [false, true] {
        spread(marks, measured, matches!(model, Model::Affine | Model::ScaleXy))?;
    }
    let mean = |of: fn(&Mark) -> Vector| {
        marks.iter().map(of).fold(Vector::ZERO, |a, b| a + b) * (1.0 / marks.len() as f64)
    };
    let (from, to) = (mean(|m| m.file), mean(|m| m.machine));
    let mirror = if options.mirror { -1.0 } else { 1.0 };
    let centred: Vec<(Vector, Vector)> = marks
        .iter()
        .map(|m| {
            let p = m.file - from;
            (Vector::new(p.x, p.y * mirror), m.machine - to)
        })
        .collect();
    let mut linear = match model {
        Model::Auto | Model::Shift => Matrix::IDENTITY,
        Model::Rigid | Model::Similarity => similarity(&centred, model == Model::Rigid),
        Model::ScaleXy => scale_xy(&centred)?,
        Model::Affine => affine(&centred)?,
    };
    if linear.det() < 0.0 {
        return Err(if options.mirror { Misfit::NotMirrored } else { Misfit::Mirrored });
    }
    linear = linear * Matrix::new(1.0, 0.0, 0.0, mirror);
    let transform = Transform { linear, shift: to - linear * from };
    let residuals: Vec<Vector> =
        marks.iter().map(|m| m.machine - transform.apply(m.file)).collect();
    let sum: f64 = residuals.iter().map(|r| r.dot(*r)).sum();
    let rms = sqrt(sum / residuals.len() as f64);
    let tolerance = options.tolerance;
    if !matches!(
        rms.partial_cmp(&tolerance),
        Some(core::cmp::Ordering::Less | core::cmp::Ordering::Equal)
    ) {
        let worst = (1..).zip(residuals.iter().map(|r| r.length()));
        let worst = worst.fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        return Err(Misfit::Residual(rms, tolerance, worst.0, worst.1));
    }
    Ok(Fit { transform, model, residuals, rms })
}

/// Checks that the marks lie apart, and beside a line if the model needs that.
fn spread(marks: &[Mark], measured: bool, beside: bool) -> Result<(), Misfit> {
    let point = |m: &Mark| if measured { m.machine } else { m.file };
    for (i, a) in (1..).zip(marks) {
        for (j, b) in (1..).zip(marks).skip(i) {
            let distance = (point(a) - point(b)).length();
            if distance < APART {
                return Err(Misfit::Close(i, j, distance, measured));
            }
        }
    }
    let n = marks.len() as f64;
    let mean = marks.iter().map(point).fold(Vector::ZERO, |a, b| a + b) * (1.0 / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in marks.iter().map(|m| point(m) - mean) {
        xx += p.x * p.x;
        xy += p.x * p.y;
        yy += p.y * p.y;
    }
    let (half, radius) = ((xx + yy) / 2.0, hypot((xx - yy) / 2.0, xy));
    let (larger, smaller) = (sqrt(half + radius), sqrt((half - radius).max(0.0)));
    if beside && smaller < SPREAD * larger {
        return Err(Misfit::Collinear(measured));
    }
    Ok(())
}

/// Returns the best turn, with the best scale unless it is 1.
fn similarity(pairs: &[(Vector, Vector)], rigid: bool) -> Matrix {
    let (mut a, mut b, mut size) = (0.0, 0.0, 0.0);
    for (p, q) in pairs {
        a += p.dot(*q);
        b += p.cross(*q);
        size += p.dot(*p);
    }
    let by = if rigid { hypot(a, b) } else { size };
    let (a, b) = (a / by, b / by);
    if a.is_finite() && b.is_finite() { Matrix::new(a, -b, b, a) } else { Matrix::IDENTITY }
}

fn affine(pairs: &[(Vector, Vector)]) -> Result<Matrix, Misfit> {
    let sum = |of: fn(Vector, Vector) -> Matrix| {
        pairs.iter().fold(Matrix::new(0.0, 0.0, 0.0, 0.0), |a, (p, q)| {
            let b = of(*p, *q);
            Matrix::new(a.m11 + b.m11, a.m12 + b.m12, a.m21 + b.m21, a.m22 + b.m22)
        })
    };
    let across = sum(|p, q| Matrix::new(q.x * p.x, q.x * p.y, q.y * p.x, q.y * p.y));
    let own = sum(|p, _| Matrix::new(p.x * p.x, p.x * p.y, p.y * p.x, p.y * p.y));
    Ok(across * own.inverse().ok_or(Misfit::Collinear(false))?)
}

/// Returns the best turn and scales without a squareness error: the affine map, refined by Gauss and Newton's method.
fn scale_xy(pairs: &[(Vector, Vector)]) -> Result<Matrix, Misfit> {
    let start = Transform { linear: affine(pairs)?, shift: Vector::ZERO }.parts();
    let mut now = [start.turn.to_radians(), start.scale_x, start.scale_y];
    for _ in 0..STEPS {
        let [turn, scale_x, scale_y] = now;
        let turned = Matrix::rotation(turn);
        let mut normal = [[0.0; 4]; 3];
        for (p, q) in pairs {
            let upright = Vector::new(p.x * scale_x, p.y * scale_y);
            let residual = *q - turned * upright;
            let columns = [
                turned * Vector::new(-upright.y, upright.x),
                turned * Vector::new(p.x, 0.0),
                turned * Vector::new(0.0, p.y),
            ];
            for (row, a) in normal.iter_mut().zip(columns) {
                let [r0, r1, r2, right] = row;
                let [b0, b1, b2] = columns;
                *r0 += a.dot(b0);
                *r1 += a.dot(b1);
                *r2 += a.dot(b2);
                *right += a.dot(residual);
            }
        }
        let step = solve(normal).ok_or(Misfit::Collinear(false))?;
        let mut largest = 0.0_f64;
        for (to, by) in now.iter_mut().zip(step) {
            *to += by;
            largest = largest.max(fabs(by));
        }
        if largest < 1e-15 {
            break;
        }
    }
    let [turn, scale_x, scale_y] = now;
    let turn = atan2(libm::sin(turn), libm::cos(turn)).to_degrees();
    let parts = Parts { turn, scale_x, scale_y, shear: 0.0, shift: Vector::ZERO };
    Ok(Transform::from_parts(&parts).linear)
}

/// Solves three symmetric positive equations; the right side is the last column.
fn solve(rows: [[f64; 4]; 3]) -> Option<[f64; 3]> {
    let [[a, b, c, p], [_, d, e, q], [_, _, f, r]] = rows;
    let det = a * (d * f - e * e) - b * (b * f - e * c) + c * (b * e - d * c);
    let x = p * (d * f - e * e) - b * (q * f - e * r) + c * (q * e - d * r);
    let y = a * (q * f - r * e) - p * (b * f - e * c) + c * (b * r - q * c);
    let z = a * (d * r - e * q) - b * (b * r - q * c) + p * (b * e - d * c);
    let out = [x / det, y / det, z / det];
    out.iter().all(|v| v.is_finite()).then_some(out)
}

#[cfg(test)]
mod tests;
