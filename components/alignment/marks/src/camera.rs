//! The camera: from pixels to the machine, and its calibration.

use core::fmt;
use hal_align::{Conditions, Mark, Matrix, Misfit, Model, Vector, fit};

/// Largest residual of a calibration, in pixels.
const RESIDUAL: f64 = 0.2;

/// Camera on a machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From pixels to millimetres of the machine: scale, angle, and the downward Y of pictures.
    pub linear: Matrix,
    /// From the machine's position to the place in the middle of the picture, in millimetres.
    pub offset: Vector,
}

impl Camera {
    /// Returns the place on the machine of a place in a picture of this size, taken at a position of the machine.
    #[must_use]
    pub fn machine(&self, position: Vector, size: (usize, usize), pixel: Vector) -> Vector {
        position + self.offset + self.linear * (pixel - Self::middle(size))
    }

    /// Returns the middle of a picture of this size, in pixels.
    #[must_use]
    pub fn middle(size: (usize, usize)) -> Vector {
        Vector::new(size.0 as f64 / 2.0, size.1 as f64 / 2.0)
    }

    /// Returns the number of pixels of a length in millimetres.
    #[must_use]
    pub fn pixels(&self, mm: f64) -> f64 {
        mm / libm::sqrt(libm::fabs(self.linear.det()))
    }
}

/// View of a mark from a position of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Position of the machine in millimetres.
    pub position: Vector,
    /// Centre of the mark in pixels.
    pub pixel: Vector,
}

/// Result of a calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// From pixels to millimetres of the machine.
    pub linear: Matrix,
    /// Largest residual in pixels.
    pub residual: f64,
}

/// Reason why sights do not calibrate a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraProblem {
    /// Fewer than three positions.
    Count(usize),
    /// Positions on a line, or too close.
    Positions,
    /// The mark does not move in the picture as the machine does.
    Standing,
    /// A residual in pixels.
    Residual(f64),
}

impl fmt::Display for CameraProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(n) => write!(f, "{n} positions: at least 3 beside a line are needed"),
            Self::Positions => f.write_str("the positions lie on a line or too close together"),
            Self::Standing => {
                f.write_str("the mark does not move in the picture as the machine does")
            }
            Self::Residual(by) => write!(
                f,
                "a position is {by:.2} pixels off, and {RESIDUAL} are allowed: the mark is another one, or the machine has play"
            ),
        }
    }
}

/// Calibrates a camera by one mark that is seen from several positions.
///
/// # Errors
/// The sights do not determine the camera, or contradict each other.
pub fn calibrate(sights: &[Sight]) -> Result<Calibration, CameraProblem> {
    // The fit is made for marks that lie at least 5 mm apart: here a unit is a micrometre.
    const UNIT: f64 = 1000.0;
    let marks: Vec<Mark> =
        sights.iter().map(|s| Mark { file: s.position * UNIT, machine: s.pixel }).collect();
    let options = |mirror| Conditions { model: Model::Affine, tolerance: 1e9, mirror };
    let found = match fit(&marks, &options(true)) {
        Err(Misfit::NotMirrored) => fit(&marks, &options(false)),
        other => other,
    };
    let found = found.map_err(|e| match e {
        Misfit::Count(n, _) => CameraProblem::Count(n),
        Misfit::Close(.., false) | Misfit::Collinear(false) => CameraProblem::Positions,
        _ => CameraProblem::Standing,
    })?;
    let residual = found.residuals.iter().map(|r| r.length()).fold(0.0, f64::max);
    if residual > RESIDUAL {
        return Err(CameraProblem::Residual(residual));
    }
    let back = found.transform.linear.inverse().ok_or(CameraProblem::Standing)?;
    let scale = -1.0 / UNIT;
    let linear =
        Matrix::new(back.m11 * scale, back.m12 * scale, back.m21 * scale, back.m22 * scale);
    Ok(Calibration { linear, residual })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.02 mm per pixel, turned by 3 degrees, with a downward Y.
    fn linear() -> Matrix {
        Matrix::rotation(3.0_f64.to_radians()) * Matrix::new(0.02, 0.0, 0.0, -0.02)
    }

    fn near(got: f64, wanted: f64, within: f64) {
        assert!((got - wanted).abs() <= within, "{got}, must be {wanted}");
    }

    #[test]
    fn the_vectors_of_the_reference() {
        let m = linear();
        for (got, wanted) in
            [(m.m11, 0.019973), (m.m12, 0.001047), (m.m21, 0.001047), (m.m22, -0.019973)]
        {
            near(got, wanted, 5e-7);
        }
        let moved = |by: Vector| Vector::ZERO - m.inverse().unwrap() * by;
        let (x, y) = (moved(Vector::new(2.0, 0.0)), moved(Vector::new(0.0, 2.0)));
        for (got, wanted) in [(x.x, -99.863), (x.y, -5.234), (y.x, -5.234), (y.y, 99.863)] {
            near(got, wanted, 5e-4);
        }
        let camera = Camera { linear: m, offset: Vector::new(-35.2, 12.4) };
        let at = camera.machine(Vector::new(100.0, 50.0), (640, 480), Vector::new(412.5, 180.25));
        near(at.x, 66.5849, 5e-5);
        near(at.y, 63.6902, 5e-5);
    }

    #[test]
    fn a_camera_is_calibrated_from_five_positions() {
        let m = linear();
        let cross = [(0.0, 0.0), (2.0, 0.0), (-2.0, 0.0), (0.0, 2.0), (0.0, -2.0)];
        let mut sights: Vec<Sight> = cross
            .iter()
            .map(|p| Vector::new(p.0, p.1))
            .map(|by| Sight {
                position: Vector::new(300.0, 20.0) + by,
                pixel: Vector::new(322.0, 236.0) - m.inverse().unwrap() * by,
            })
            .collect();
        let found = calibrate(&sights).unwrap();
        near(found.linear.m11, m.m11, 1e-9);
        near(found.linear.m12, m.m12, 1e-9);
        near(found.linear.m22, m.m22, 1e-9);
        near(found.residual, 0.0, 1e-9);
        sights[2].pixel.x += 1.0;
        let refused = calibrate(&sights).unwrap_err();
        assert!(matches!(refused, CameraProblem::Residual(by) if by > 0.2), "{refused}");
        assert_eq!(calibrate(&sights[..2]), Err(CameraProblem::Count(2)));
        assert_eq!(calibrate(&sights[..3]), Err(CameraProblem::Positions));
        let still: Vec<Sight> =
            sights.iter().map(|s| Sight { pixel: Vector::new(1.0, 1.0), ..*s }).collect();
        assert_eq!(calibrate(&still), Err(CameraProblem::Standing));
    }
}
