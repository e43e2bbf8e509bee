//! Centre of a mark by its edge: maximum likelihood with white noise.
//!
//! The centroid weighs all pixels of the band around the edge alike, although those far from the edge carry no information. Here
//! each weighs as much as its brightness depends on the centre: least squares of the profile of a blurred edge, which
//! is the estimator that reaches the bound of Cramér and Rao (README).

use crate::moments::{Covered, Moments};
use hal_align::{Matrix, Vector};
use libm::{erf, exp, fabs, hypot, sqrt};

/// Steps of Gauss and Newton; each one squares what is left.
const STEPS: usize = 3;
/// Largest correction of the centroid, in pixels: beyond it the edge is not that of the shape.
const LARGEST: f64 = 0.5;
/// Deviation of the edge's blur, in pixels: that of the pixels themselves, and what the band around the edge can hold.
const BLUR: (f64, f64) = (0.4, 2.0);

/// Circle or square, as far as any linear map may change it.
struct Outline {
    centre: Vector,
    /// From pixels to the unit circle, or to the square from -1 to 1.
    unit: Matrix,
    is_square: bool,
    /// Length of the edge in pixels.
    length: f64,
}

/// Centre with its deviation in each coordinate, in pixels.
pub(crate) struct Refined {
    pub(crate) centre: Vector,
    pub(crate) deviation: f64,
}

/// Returns the centre that fits the edge best; the search starts at the centre of the moments. `mass` has the pixels of the
/// mark, and `moments` are theirs; `edge` has those around the edge with the noise in their parts; `noise` is the deviation of
/// a part.
pub(crate) fn refine(
    mass: &[Covered],
    edge: &[Covered],
    moments: &Moments,
    is_square: bool,
    noise: f64,
) -> Option<Refined> {
    let mut outline = Outline::of(mass, moments, is_square)?;
    let spread: f64 = edge.iter().map(|(_, _, c)| c * (1.0 - c) + noise * noise).sum();
    // Along a normal, the integral of c (1 - c) of a blurred edge is its deviation over the root of pi.
    let blur = sqrt(core::f64::consts::PI) * spread / outline.length;
    let blur = if blur > BLUR.0 { blur.min(BLUR.1) } else { BLUR.0 };
    let mut information = [0.0; 3];
    for _ in 0..STEPS {
        information = [0.0; 3];
        let mut pull = Vector::ZERO;
        for (x, y, part) in edge {
            let (expected, gradient) = outline.profile(Vector::new(*x, *y), blur);
            information[0] += gradient.x * gradient.x;
            information[1] += gradient.x * gradient.y;
            information[2] += gradient.y * gradient.y;
            pull = pull + gradient * (part - expected);
        }
        let [xx, xy, yy] = information;
        let step = Matrix::new(xx, xy, xy, yy).inverse()? * pull;
        outline.centre = outline.centre + step;
        let off = (outline.centre - moments.centre).length();
        if !matches!(off.partial_cmp(&LARGEST), Some(core::cmp::Ordering::Less)) {
            return None;
        }
    }
    let deviation = noise / sqrt((information[0] + information[2]) / 2.0);
    deviation.is_finite().then_some(Refined { centre: outline.centre, deviation })
}

impl Outline {
    /// Returns the outline whose moments are those of the mark.
    fn of(mass: &[Covered], moments: &Moments, is_square: bool) -> Option<Self> {
        let Moments { centre, mass: m, xx, xy, yy, .. } = *moments;
        let (xx, xy, yy) = (xx / m, xy / m, yy / m);
        // The root of the second moments, times the ratio of the shape's half size to its own.
        let root = sqrt(xx * yy - xy * xy);
        let ratio = if is_square { sqrt(3.0) } else { 2.0 } / sqrt(xx + yy + 2.0 * root);
        let to_pixels =
            Matrix::new((xx + root) * ratio, xy * ratio, xy * ratio, (yy + root) * ratio);
        let mut unit = to_pixels.inverse()?;
        let (larger, smaller) = to_pixels.stretches();
        let mut length = core::f64::consts::TAU * sqrt((larger * larger + smaller * smaller) / 2.0);
        if is_square {
            let in_unit = |(x, y, c): &Covered| {
                let w = unit * (Vector::new(*x, *y) - centre);
                (w.x, w.y, *c)
            };
            let angle = Moments::about(Vector::ZERO, mass.iter().map(in_unit)).angle();
            unit = Matrix::rotation(-angle) * unit;
            length *= 4.0 / core::f64::consts::PI;
        }
        length.is_finite().then_some(Self { centre, unit, is_square, length })
    }

    /// Returns the part of a pixel at a place that the mark covers, and how it changes with the centre. At the corner of a
    /// square both sides cover.
    fn profile(&self, place: Vector, blur: f64) -> (f64, Vector) {
        let Matrix { m11, m12, m21, m22 } = self.unit;
        let w = self.unit * (place - self.centre);
        let side = |value: f64, gradient: Vector| {
            let size = gradient.length().max(1e-12);
            let at = (1.0 - value) / (size * blur);
            let slope = exp(-at * at / 2.0) / (blur * sqrt(core::f64::consts::TAU));
            let covered = 0.5 + 0.5 * erf(at * core::f64::consts::FRAC_1_SQRT_2);
            (covered, gradient * (slope / size))
        };
        if self.is_square {
            let row = |n: f64, row: Vector| side(fabs(n), if n < 0.0 { row * -1.0 } else { row });
            let (x, y) = (row(w.x, Vector::new(m11, m12)), row(w.y, Vector::new(m21, m22)));
            return (x.0 * y.0, x.1 * y.0 + y.1 * x.0);
        }
        let far = hypot(w.x, w.y).max(1e-12);
        let gradient = Vector::new(m11 * w.x + m21 * w.y, m12 * w.x + m22 * w.y) * (1.0 / far);
        side(far, gradient)
    }
}

#[cfg(test)]
mod tests {
    //! Edges without pixels' noise.

    use super::*;

    /// Draws a blurred shape: a circle or square of half size 12 that is stretched and turned.
    fn edge(centre: Vector, map: Matrix, is_square: bool, blur: f64) -> Vec<Covered> {
        let unit = map.inverse().unwrap();
        let outline = Outline { centre, unit, is_square, length: 1.0 };
        let all = (0..60 * 60).map(|n| (f64::from(n % 60) + 0.5, f64::from(n / 60) + 0.5));
        let cover = |(x, y)| (x, y, outline.profile(Vector::new(x, y), blur).0);
        all.map(cover).collect()
    }

    #[test]
    fn the_centre_of_a_stretched_shape_is_found_from_a_start_beside_it() {
        let at = Vector::new(30.3, 29.8);
        for is_square in [false, true] {
            for stretch in [1.0, 1.1] {
                let map = Matrix::rotation(0.3) * Matrix::new(12.0 * stretch, 0.5, 0.0, 12.0);
                let all = edge(at, map, is_square, 1.0);
                let band: Vec<Covered> =
                    all.iter().copied().filter(|p| 0.001 < p.2 && p.2 < 0.999).collect();
                let start = Moments::about(at + Vector::new(0.25, -0.2), all.iter().copied());
                let found = refine(&all, &band, &start, is_square, 0.05).unwrap();
                let off = (found.centre - at).length();
                assert!(off < 2e-3, "{is_square} {stretch}: {off}");
                // The bound: twice the noise squared times the blur, over the root of pi times the radius of a circle.
                let bound = 0.05 * sqrt(2.0 / (sqrt(core::f64::consts::PI) * 12.0 * stretch));
                let size = if is_square { sqrt(core::f64::consts::PI / 4.0) } else { 1.0 };
                let ratio = found.deviation / (bound * size);
                assert!((0.9..1.1).contains(&ratio), "{is_square} {stretch}: {ratio}");
            }
        }
        // What has no edge gives nothing.
        assert!(refine(&[], &[], &Moments::about(at, []), false, 0.05).is_none());
    }
}
