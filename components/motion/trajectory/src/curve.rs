//! Realtime. Curves and their derivatives by the path coordinate.

use crate::pose::{Group, Pose};

/// A curve over the path coordinate `s`, which runs from 0 to the curve's length.
#[expect(clippy::large_enum_variant, reason = "a box would need memory in the servo thread")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// A straight line.
    Line {
        /// Pose at 0.
        start: Pose,
        /// Derivative.
        slope: Pose,
    },
    /// A circle or helix in XYZ whose other axes move linearly: centre + cos·arm + sin·side + s·drift.
    Arc {
        /// Centre, with the linear axes at their start.
        center: Pose,
        /// Vector from the centre to the start.
        arm: [f64; 3],
        /// Vector from the centre to the point a quarter turn later.
        side: [f64; 3],
        /// Angle per unit of `s`, in radians.
        rate: f64,
        /// Linear motion per unit of `s`.
        drift: Pose,
    },
    /// A polynomial of degree five in `u = s / length`.
    Poly {
        /// Coefficients of 1, u, …, u⁵.
        c: [Pose; 6],
        /// Length in `s`.
        length: f64,
    },
}

/// A pose with its first three derivatives by the path coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// Pose.
    pub pose: Pose,
    /// First derivative.
    pub first: Pose,
    /// Second derivative.
    pub second: Pose,
    /// Third derivative.
    pub third: Pose,
}

impl Curve {
    /// Returns the pose at `s`.
    pub fn pose(&self, s: f64) -> Pose {
        match self {
            Self::Line { start, slope } => *start + *slope * s,
            Self::Arc { center, arm, side, rate, drift } => {
                let (sin, cos) = libm::sincos(rate * s);
                *center + *drift * s + turned(arm, side, cos, sin)
            }
            Self::Poly { c, length } => {
                let u = s / length;
                c.iter().rev().fold(Pose::ZERO, |sum, k| sum * u + *k)
            }
        }
    }

    /// Returns the pose and its derivatives at `s`.
    pub fn at(&self, s: f64) -> Derivatives {
        self.derive::<true>(s)
    }

    /// Returns the pose and its first two derivatives at `s`; the third is zero.
    pub(crate) fn twice(&self, s: f64) -> Derivatives {
        self.derive::<false>(s)
    }

    fn derive<const THIRD: bool>(&self, s: f64) -> Derivatives {
        match self {
            Self::Line { start, slope } => {
                Derivatives { pose: *start + *slope * s, first: *slope, ..Derivatives::default() }
            }
            Self::Arc { center, arm, side, rate, drift } => {
                let (sin, cos) = libm::sincos(rate * s);
                let radial = turned(arm, side, cos, sin);
                let along = turned(arm, side, -sin, cos);
                Derivatives {
                    pose: *center + *drift * s + radial,
                    first: *drift + along * *rate,
                    second: radial * (-rate * rate),
                    third: if THIRD { along * (-rate * rate * rate) } else { Pose::ZERO },
                }
            }
            Self::Poly { c, length } => {
                let u = s / length;
                let [c0, c1, c2, c3, c4, c5] = *c;
                let (k1, k2) = (1.0 / length, 1.0 / (length * length));
                let k3 = k2 * k1;
                Derivatives {
                    pose: ((((c5 * u + c4) * u + c3) * u + c2) * u + c1) * u + c0,
                    first: ((((c5 * (5.0 * u) + c4 * 4.0) * u + c3 * 3.0) * u + c2 * 2.0) * u + c1)
                        * k1,
                    second: (((c5 * (20.0 * u) + c4 * 12.0) * u + c3 * 6.0) * u + c2 * 2.0) * k2,
                    third: if THIRD {
                        ((c5 * (60.0 * u) + c4 * 24.0) * u + c3 * 6.0) * k3
                    } else {
                        Pose::ZERO
                    },
                }
            }
        }
    }

    /// Returns true if the axes of a group change along the curve.
    pub(crate) fn moves(&self, group: Group) -> bool {
        let still = |p: &Pose| p.group(group) == [0.0; 3];
        match self {
            Self::Line { slope, .. } => !still(slope),
            Self::Arc { drift, .. } => group == Group::Xyz || !still(drift),
            Self::Poly { c, .. } => !c.iter().skip(1).all(still),
        }
    }

    /// Curve of degree five with these values and first two derivatives at its ends.
    pub fn hermite(a: &Derivatives, b: &Derivatives, length: f64) -> Self {
        let l = length;
        let (v0, a0) = (a.first * l, a.second * (l * l));
        let d = b.pose - a.pose - v0 - a0 * 0.5;
        let e = b.first * l - v0 - a0;
        let f = b.second * (l * l) - a0;
        Self::Poly {
            c: [
                a.pose,
                v0,
                a0 * 0.5,
                d * 10.0 - e * 4.0 + f * 0.5,
                d * -15.0 + e * 7.0 - f,
                d * 6.0 - e * 3.0 + f * 0.5,
            ],
            length,
        }
    }
}

impl Derivatives {
    /// Returns the Bernstein points of the curve of degree five from these values and derivatives to those of `end`.
    pub(crate) fn bernstein(&self, end: &Self, length: f64) -> [Pose; 6] {
        let l = length;
        [
            self.pose,
            self.pose + self.first * (l / 5.0),
            self.pose + self.first * (0.4 * l) + self.second * (l * l / 20.0),
            end.pose - end.first * (0.4 * l) + end.second * (l * l / 20.0),
            end.pose - end.first * (l / 5.0),
            end.pose,
        ]
    }
}

/// Returns the XYZ vector cos·arm + sin·side.
const fn turned(arm: &[f64; 3], side: &[f64; 3], cos: f64, sin: f64) -> Pose {
    let ([a, b, c], [x, y, z]) = (*arm, *side);
    Pose::from_xyz([cos * a + sin * x, cos * b + sin * y, cos * c + sin * z])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives agree with differences of the curve, and a curve through two ends meets both.
    #[test]
    fn derivatives_agree_with_differences() {
        let slope = Pose([0.6, 0.8, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.2]);
        let line = Curve::Line { start: Pose([1.0; 9]), slope };
        let arc = Curve::Arc {
            center: Pose([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            arm: [4.0, 0.0, 0.0],
            side: [0.0, 4.0, 0.0],
            rate: 0.25,
            drift: Pose([0.0, 0.0, 0.1, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        };
        let blend = Curve::hermite(&line.at(1.0), &arc.at(2.0), 3.0);
        let (a, b) = (blend.at(0.0), blend.at(3.0));
        for (x, y) in [(a, line.at(1.0)), (b, arc.at(2.0))] {
            assert!((x.pose - y.pose).dot_all(&(x.pose - y.pose)) < 1e-26);
            assert!((x.first - y.first).dot_all(&(x.first - y.first)) < 1e-26);
            assert!((x.second - y.second).dot_all(&(x.second - y.second)) < 1e-26);
        }
        for curve in [line, arc, blend] {
            for s in [0.5, 1.0, 2.2] {
                let e = 1e-4;
                let (m, p, d) = (curve.at(s - e), curve.at(s + e), curve.at(s));
                let near = |x: Pose, y: Pose| (x - y).dot_all(&(x - y)).sqrt() < 1e-6;
                assert!(near((p.pose - m.pose) * (0.5 / e), d.first));
                assert!(near((p.first - m.first) * (0.5 / e), d.second));
                assert!(near((p.second - m.second) * (0.5 / e), d.third));
                assert_eq!(
                    curve.pose(s).0.map(|x| (x * 1e9).round()),
                    d.pose.0.map(|x| (x * 1e9).round())
                );
            }
        }
    }
}
