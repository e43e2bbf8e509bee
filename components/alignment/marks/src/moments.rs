//! Moments of the coverage of pixels about a centre.

use hal_align::Vector;
use libm::atan2;

/// Pixel with the part that the mark covers of it.
pub(crate) type Covered = (f64, f64, f64);

/// Moments about a centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    pub(crate) centre: Vector,
    pub(crate) mass: f64,
    pub(crate) xx: f64,
    pub(crate) xy: f64,
    pub(crate) yy: f64,
    /// Sum of the fourth power of `u + iv`.
    pub(crate) real: f64,
    pub(crate) imaginary: f64,
}

impl Moments {
    /// Returns the moments of pixels about this centre.
    pub(crate) fn about(centre: Vector, covered: impl IntoIterator<Item = Covered>) -> Self {
        let mut out =
            Self { centre, mass: 0.0, xx: 0.0, xy: 0.0, yy: 0.0, real: 0.0, imaginary: 0.0 };
        for (x, y, c) in covered {
            let (u, v) = (x - centre.x, y - centre.y);
            out.mass += c;
            out.xx += c * u * u;
            out.xy += c * u * v;
            out.yy += c * v * v;
            let (re, im) = (u * u - v * v, 2.0 * u * v);
            out.real += c * (re * re - im * im);
            out.imaginary += c * 2.0 * re * im;
        }
        out
    }

    /// Returns the angle of a square's sides in radians, between -π/4 and π/4, from X towards Y.
    pub(crate) fn angle(&self) -> f64 {
        atan2(-self.imaginary, -self.real) / 4.0
    }
}

/// Returns the centroid of pixels.
pub(crate) fn centroid(covered: &[Covered]) -> Vector {
    let (mut mass, mut x, mut y) = (0.0, 0.0, 0.0);
    for (px, py, c) in covered {
        (mass, x, y) = (mass + c, x + c * px, y + c * py);
    }
    Vector::new(x / mass, y / mass)
}
