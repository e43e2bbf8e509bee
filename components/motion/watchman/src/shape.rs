//! Programmed shapes, and the distance of a pose from them.

/// Number of axes: X Y Z A B C U V W.
pub const AXES: usize = 9;

use crate::spline::Spline;

/// A programmed shape in nine axes.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A straight line.
    Line {
        /// Start.
        from: [f64; AXES],
        /// End.
        to: [f64; AXES],
    },
    /// An arc or helix in XYZ; the other axes move in proportion to the angle.
    Arc {
        /// Start.
        from: [f64; AXES],
        /// End.
        to: [f64; AXES],
        /// Centre at the height of the start.
        center: [f64; 3],
        /// Unit vector of the axis; a positive angle turns by the right-hand rule.
        normal: [f64; 3],
        /// Angle in radians, negative for clockwise.
        angle: f64,
    },
    /// A B-spline or NURBS.
    Spline(Box<Spline>),
}

impl Shape {
    /// Pose at the fraction `t`, from 0 to 1.
    pub fn at(&self, t: f64) -> [f64; AXES] {
        match self {
            Self::Line { from, to } => mix(from, to, t),
            Self::Arc { from, to, center, normal, angle } => {
                let arm = sub3(xyz(from), *center);
                let side = cross(*normal, arm);
                let (sin, cos) = libm::sincos(angle * t);
                let rise = dot3(sub3(xyz(to), xyz(from)), *normal) * t;
                let mut pose = mix(from, to, t);
                for (k, value) in pose.iter_mut().take(3).enumerate() {
                    let part = |v: &[f64; 3]| v.get(k).copied().unwrap_or(0.0);
                    *value =
                        part(center) + cos * part(&arm) + sin * part(&side) + rise * part(normal);
                }
                pose
            }
            Self::Spline(spline) => spline.at(t),
        }
    }

    /// Returns the least value of `weigh` over the points of the shape, which receives the distances in XYZ, ABC and UVW
    /// and must not fall when one of them rises. If `exact` is true, the least value is exact on a line, and on an arc within a
    /// quarter of a turn of the nearest points; else it is the value at the nearest point (on an arc, of every turn), an upper
    /// bound. On a spline it is the first value up to `enough`, else the least, of those between samples: between all of
    /// them if `exact` is true, else beside those that are nearer than their neighbours.
    pub(crate) fn ratio(
        &self,
        pose: &[f64; AXES],
        exact: bool,
        enough: f64,
        weigh: impl Fn([f64; 3]) -> f64,
    ) -> f64 {
        let at = |t: f64| weigh(distances(&self.at(t), pose));
        if let Self::Spline(spline) = self {
            let mut value = f64::INFINITY;
            let sampled = |sample: &[f64; AXES]| weigh(distances(sample, pose));
            spline.near(exact, sampled, |low, high| {
                if value > enough {
                    value = value.min(least(low, high, 32, enough, at));
                }
            });
            return value;
        }
        let (Self::Line { from, to } | Self::Arc { from, to, .. }) = self else {
            return f64::INFINITY;
        };
        let moves = |first: usize| {
            let by = sub3(group(to, first), group(from, first));
            square(by) > 0.0
        };
        if let Self::Arc { angle, .. } = self {
            // Up to a quarter of a turn from the nearest point, the distance in XYZ rises.
            let quarter = core::f64::consts::FRAC_PI_2 / angle.abs();
            let is_more = exact && (moves(3) || moves(6));
            let mut value = f64::INFINITY;
            self.candidates(pose, |t| {
                let (low, high) = ((t - quarter).max(0.0), (t + quarter).min(1.0));
                value = value.min(at(t));
                if is_more {
                    value = value.min(least(low, high, 64, f64::NEG_INFINITY, at));
                }
            });
            return value;
        }
        if !exact || [0, 3, 6].iter().filter(|k| moves(**k)).count() < 2 {
            let mut value = f64::INFINITY;
            self.candidates(pose, |t| value = at(t));
            return value;
        }
        // The larger of convex functions is convex: golden-section search finds the least value.
        least(0.0, 1.0, 64, f64::NEG_INFINITY, at)
    }

    /// Offers the fractions at which the shape is nearest to `pose`: in XYZ if it moves there, else in UVW, else in ABC.
    fn candidates(&self, pose: &[f64; AXES], mut offer: impl FnMut(f64)) {
        match self {
            Self::Line { from, to } => {
                for first in [0, 6, 3] {
                    let (a, b, p) = (group(from, first), group(to, first), group(pose, first));
                    let along = sub3(b, a);
                    let square = dot3(along, along);
                    if square > 0.0 {
                        return offer(fraction(dot3(sub3(p, a), along) / square));
                    }
                }
                offer(0.0);
            }
            Self::Spline(_) => {}
            Self::Arc { from, to, center, normal, angle } => {
                let arm = sub3(xyz(from), *center);
                let side = cross(*normal, arm);
                let away = sub3(xyz(pose), *center);
                let rise = dot3(sub3(xyz(to), xyz(from)), *normal);
                let turn = angle.signum();
                let mut place = turn * libm::atan2(dot3(away, side), dot3(away, arm));
                if place < 0.0 {
                    place += core::f64::consts::TAU;
                }
                let whole = angle.abs();
                offer(0.0);
                offer(1.0);
                // One candidate per turn, refined where the helix rises, and one at the height of the pose.
                let helix = Helix { arm, side, normal: *normal, rise: rise / whole, away, turn };
                let mut turned = place;
                while turned < whole + core::f64::consts::TAU {
                    let angle = if rise == 0.0 { turned } else { helix.refine(turned) };
                    offer(fraction(angle / whole));
                    turned += core::f64::consts::TAU;
                }
                if rise != 0.0 {
                    let height = dot3(away, *normal) / helix.rise;
                    offer(fraction(helix.refine(height) / whole));
                }
            }
        }
    }
}

/// A helix around its centre, and a point beside it.
struct Helix {
    arm: [f64; 3],
    side: [f64; 3],
    normal: [f64; 3],
    /// Rise per radian turned.
    rise: f64,
    away: [f64; 3],
    /// Sense of rotation, 1 or -1.
    turn: f64,
}

impl Helix {
    /// Newton's method for the angle at which the helix is nearest to the point; a poor result costs accuracy only, as the
    /// distance is taken at the angle that is returned.
    fn refine(&self, start: f64) -> f64 {
        let square = dot3(self.arm, self.arm);
        let (x, y) = (dot3(self.away, self.arm), dot3(self.away, self.side) * self.turn);
        let z = dot3(self.away, self.normal);
        let mut angle = start;
        for _ in 0..12 {
            let (sin, cos) = libm::sincos(angle);
            // Half the derivative of the squared distance, and its derivative.
            let slope = x * sin - y * cos + self.rise * (self.rise * angle - z);
            let bend = x * cos + y * sin + self.rise * self.rise;
            let step = if bend > 0.1 * square { slope / bend } else { slope / square };
            angle -= if step.abs() < 0.5 { step } else { 0.5 * step.signum() };
            if step.abs() < 1e-12 {
                break;
            }
        }
        angle
    }
}

/// Golden-section search for the least value between two fractions; its ends count too. It ends at the first value up to
/// `enough`.
fn least(from: f64, to: f64, rounds: u32, enough: f64, at: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (from, to);
    let mut best = at(low).min(at(high));
    for _ in 0..rounds {
        if best <= enough {
            break;
        }
        let (a, b) = (low + 0.381_966 * (high - low), low + 0.618_034 * (high - low));
        let (x, y) = (at(a), at(b));
        best = best.min(x).min(y);
        if x < y {
            high = b;
        } else {
            low = a;
        }
    }
    best
}

/// Returns the distances of two poses in XYZ, ABC and UVW.
pub(crate) fn distances(a: &[f64; AXES], b: &[f64; AXES]) -> [f64; 3] {
    along(a, b).map(|way| square(way).sqrt())
}

/// Returns the ways from a pose to another in XYZ, ABC and UVW.
pub(crate) fn along(from: &[f64; AXES], to: &[f64; AXES]) -> [[f64; 3]; 3] {
    [0, 3, 6].map(|k| sub3(group(to, k), group(from, k)))
}

/// The nearest number from 0 to 1.
fn fraction(t: f64) -> f64 {
    if t > 0.0 { t.min(1.0) } else { 0.0 }
}

fn mix(a: &[f64; AXES], b: &[f64; AXES], t: f64) -> [f64; AXES] {
    let mut out = *a;
    for (x, y) in out.iter_mut().zip(b) {
        *x = if t == 1.0 { *y } else { *x + (*y - *x) * t };
    }
    out
}

fn xyz(a: &[f64; AXES]) -> [f64; 3] {
    group(a, 0)
}

fn group(a: &[f64; AXES], first: usize) -> [f64; 3] {
    let mut out = [0.0; 3];
    for (x, y) in out.iter_mut().zip(a.iter().skip(first)) {
        *x = *y;
    }
    out
}

fn sub3(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot3(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn square(a: [f64; 3]) -> f64 {
    dot3(a, a)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
