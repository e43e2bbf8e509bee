//! Bounds of the derivatives of a curve over an interval: in closed form, or by the hull of Bernstein coefficients.

use crate::{
    curve::Curve,
    pose::{AXES, Group, Pose},
};

/// Upper bounds of the absolute values of three derivatives, per axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Of the first derivative.
    pub first: Pose,
    /// Of the second derivative.
    pub second: Pose,
    /// Of the third derivative.
    pub third: Pose,
    /// Of the length of the first derivative in the group that governs the feed.
    pub speed: f64,
}

impl Bounds {
    /// Returns the bounds of the three derivatives.
    pub(crate) const fn rows(&self) -> [&[f64; AXES]; 3] {
        [&self.first.0, &self.second.0, &self.third.0]
    }
}

impl Curve {
    /// Bounds the derivatives for `from <= s <= to`; `lead` is the group that governs the feed.
    pub fn bounds(&self, from: f64, to: f64, lead: Group) -> Bounds {
        match self {
            Self::Line { slope, .. } => {
                Bounds { first: slope.abs(), speed: slope.norm(lead), ..Bounds::default() }
            }
            Self::Arc { arm, side, rate, drift, .. } => {
                let mut out = Bounds { first: drift.abs(), ..Bounds::default() };
                let (sin, cos) = libm::sincos(rate * (0.5 * (from + to)));
                let half = Half::new((rate * (0.5 * (to - from))).abs());
                let (k1, k2) = (rate.abs(), rate * rate);
                let rows = out.first.0.iter_mut().zip(&mut out.second.0).zip(&mut out.third.0);
                for (((first, second), third), (a, b)) in rows.zip(arm.iter().zip(side)) {
                    let (radial, along) = (a * cos + b * sin, b * cos - a * sin);
                    let size = (radial * radial + along * along).sqrt();
                    let slope = half.largest(along, radial, size);
                    *first += k1 * slope;
                    *second = k2 * half.largest(radial, along, size);
                    *third = k1 * k2 * slope;
                }
                let radius = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
                let turning = (rate * radius).abs();
                // A helix moves along its axis, at right angles to the circle.
                let [x, y, z] = drift.group(Group::Xyz);
                let normal = cross(arm, side);
                let size = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
                let [nx, ny, nz] = normal;
                let rise = if size > 0.0 { (x * nx + y * ny + z * nz).abs() / size } else { 0.0 };
                let flat = (drift.dot(drift, Group::Xyz) - rise * rise).max(0.0).sqrt();
                let xyz = ((turning + flat) * (turning + flat) + rise * rise).sqrt();
                out.speed = if lead == Group::Xyz { xyz } else { drift.norm(lead) };
                out
            }
            Self::Poly { c, length } => poly(c, *length, from / length, to / length, lead),
        }
    }
}

/// Bounds of a polynomial in `u` by the Bernstein coefficients of its derivatives over `from <= u <= to`.
fn poly(c: &[Pose; 6], length: f64, from: f64, to: f64, lead: Group) -> Bounds {
    let c = shifted(c, from, to - from);
    let k = 1.0 / (length * (to - from));
    let (first, speed) = slope(&c, k, lead);
    let [_, _, c2, c3, c4, c5] = c;
    let d = [c2 * 2.0, c3 * 6.0, c4 * 12.0, c5 * 20.0];
    let third_part = 1.0 / 3.0;
    let second = [
        d[0],
        d[0] + d[1] * third_part,
        d[0] + (d[1] * 2.0 + d[2]) * third_part,
        d[0] + d[1] + d[2] + d[3],
    ];
    let d = [c3 * 6.0, c4 * 24.0, c5 * 60.0];
    let third = [d[0], d[0] + d[1] * 0.5, d[0] + d[1] + d[2]];
    Bounds { first, second: largest(&second, k * k), third: largest(&third, k * k * k), speed }
}

/// Bounds the first derivative of a polynomial in `u` over `from <= u <= to`, by the hulls of both halves.
pub(crate) fn poly_slope(c: &[Pose; 6], length: f64, from: f64, to: f64) -> Pose {
    let mut points = slopes(&shifted(c, from, to - from));
    let k = 1.0 / (length * (to - from));
    let mut worst = points[0].abs();
    // De Casteljau's construction: after each round, the first point belongs to the first half.
    for last in (0..4).rev() {
        for i in 0..=last {
            if let Some([a, b]) = points.get_mut(i..i + 2) {
                *a = (*a + *b) * 0.5;
            }
        }
        worst = worst.max(&points[0].abs());
    }
    // The points that are left are those of the second half.
    points.iter().fold(worst, |m, p| m.max(&p.abs())) * (k * (1.0 + 1e-12))
}

/// Returns the Bernstein coefficients of the first derivative, of degree 4, times the width of the interval.
fn slopes(c: &[Pose; 6]) -> [Pose; 5] {
    let [_, c1, c2, c3, c4, c5] = *c;
    let d = [c1, c2 * 2.0, c3 * 3.0, c4 * 4.0, c5 * 5.0];
    [
        d[0],
        d[0] + d[1] * 0.25,
        d[0] + d[1] * 0.5 + d[2] * (1.0 / 6.0),
        d[0] + d[1] * 0.75 + d[2] * 0.5 + d[3] * 0.25,
        d[0] + d[1] + d[2] + d[3] + d[4],
    ]
}

/// Bounds the first derivative by its Bernstein coefficients.
fn slope(c: &[Pose; 6], k: f64, lead: Group) -> (Pose, f64) {
    let first = slopes(c);
    let square = first.iter().map(|p| p.dot(p, lead)).fold(0.0, f64::max);
    (largest(&first, k), square.sqrt() * k * (1.0 + 1e-12))
}

/// Returns the largest absolute value of each axis, times `k`, rounded up.
fn largest(list: &[Pose], k: f64) -> Pose {
    list.iter().fold(Pose::ZERO, |m, p| m.max(&p.abs())) * (k * (1.0 + 1e-12))
}

/// Coefficients of the polynomial in `t`, with `u = from + width · t`.
fn shifted(c: &[Pose; 6], from: f64, width: f64) -> [Pose; 6] {
    let [mut c0, mut c1, mut c2, mut c3, mut c4, c5] = *c;
    if from != 0.0 {
        // Synthetic division, once per coefficient.
        c4 = c4 + c5 * from;
        c3 = c3 + c4 * from;
        c2 = c2 + c3 * from;
        c1 = c1 + c2 * from;
        c0 = c0 + c1 * from;
        c4 = c4 + c5 * from;
        c3 = c3 + c4 * from;
        c2 = c2 + c3 * from;
        c1 = c1 + c2 * from;
        c4 = c4 + c5 * from;
        c3 = c3 + c4 * from;
        c2 = c2 + c3 * from;
        c4 = c4 + c5 * from;
        c3 = c3 + c4 * from;
        c4 = c4 + c5 * from;
    }
    let mut scale = 1.0;
    [c0, c1, c2, c3, c4, c5].map(|x| {
        let out = x * scale;
        scale *= width;
        out
    })
}

/// Half of an interval of angles.
struct Half {
    sin: f64,
    cos: f64,
}

impl Half {
    fn new(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle.min(core::f64::consts::FRAC_PI_2));
        Self { sin, cos }
    }

    /// Returns the largest |m·cos t + n·sin t| for t up to this angle to either side; `size` is the root of m² + n². The
    /// peak is at tan t = n/m.
    fn largest(&self, m: f64, n: f64, size: f64) -> f64 {
        let (m, n) = (m.abs(), n.abs());
        let at = if n * self.cos <= m * self.sin { size } else { m * self.cos + n * self.sin };
        at * (1.0 + 1e-12) + size * 1e-12
    }
}

pub(crate) const fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_corpus::Rng;

    /// No sample of a curve exceeds its bounds, and the bounds are not far above the samples.
    #[test]
    fn bounds_hold_and_are_tight() {
        let mut rng = Rng::new(1);
        for round in 0..400 {
            let mut pose = |k: f64| Pose([0.0; 9].map(|_: f64| rng.between(-k, k)));
            let curve = if round % 2 == 0 {
                Curve::Poly { c: [0; 6].map(|_| pose(1.0)), length: 2.0 }
            } else {
                let a = pose(5.0);
                let [x, y, _] = a.group(Group::Xyz);
                Curve::Arc {
                    center: Pose::ZERO,
                    arm: [x, y, 0.0],
                    side: [-y, x, 0.0],
                    rate: 0.7,
                    drift: pose(0.3),
                }
            };
            let from = rng.between(0.0, 1.5);
            let to = from + rng.between(0.01, 0.5);
            let bounds = curve.bounds(from, to, Group::Xyz);
            let mut seen = Bounds::default();
            for k in 0..=200 {
                let d = curve.at(from + (to - from) * f64::from(k) / 200.0);
                seen.first = seen.first.max(&d.first.abs());
                seen.second = seen.second.max(&d.second.abs());
                seen.third = seen.third.max(&d.third.abs());
                seen.speed = seen.speed.max(d.first.norm(Group::Xyz));
            }
            let pairs = [
                (bounds.first, seen.first),
                (bounds.second, seen.second),
                (bounds.third, seen.third),
            ];
            for (bound, seen) in pairs {
                for (b, s) in bound.0.iter().zip(seen.0) {
                    assert!(s <= *b, "round {round}: {s} above the bound {b}");
                    assert!(*b <= 1.6 * s + 1.0, "round {round}: bound {b} of {s}");
                }
            }
            assert!(seen.speed <= bounds.speed * (1.0 + 1e-12), "round {round}");
        }
    }
}
