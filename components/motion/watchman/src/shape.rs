//! Programmed shapes, and the distance of a pose from them.

/// Number of axes: X Y Z A B C U V W.
pub const AXES: usize = 9;

/// A programmed shape in nine axes.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        }
    }

    /// Returns the fraction at which the shape is nearest to `pose`: in XYZ if it moves there, else in UVW, else in ABC.
    pub fn nearest(&self, pose: &[f64; AXES]) -> f64 {
        match self {
            Self::Line { from, to } => {
                for first in [0, 6, 3] {
                    let (a, b, p) = (group(from, first), group(to, first), group(pose, first));
                    let along = sub3(b, a);
                    let square = dot3(along, along);
                    if square > 0.0 {
                        return fraction(dot3(sub3(p, a), along) / square);
                    }
                }
                0.0
            }
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
                let mut best = (f64::INFINITY, 0.0);
                let mut offer = |t: f64| {
                    let d = square(sub3(xyz(&self.at(t)), xyz(pose)));
                    if d < best.0 {
                        best = (d, t);
                    }
                };
                offer(0.0);
                offer(1.0);
                // One candidate per turn, refined where the helix rises.
                let mut turned = place - core::f64::consts::TAU;
                while turned <= whole + core::f64::consts::TAU {
                    let t = fraction(turned / whole);
                    offer(if rise == 0.0 { t } else { self.refine(t, whole, pose) });
                    turned += core::f64::consts::TAU;
                }
                best.1
            }
        }
    }

    /// Golden-section search for the nearest fraction within 0.7 rad of `t`.
    fn refine(&self, t: f64, whole: f64, pose: &[f64; AXES]) -> f64 {
        let reach = 0.7 / whole;
        let (mut low, mut high) = ((t - reach).max(0.0), (t + reach).min(1.0));
        let far = |t: f64| square(sub3(xyz(&self.at(t)), xyz(pose)));
        for _ in 0..48 {
            let (a, b) = (low + 0.381_966 * (high - low), low + 0.618_034 * (high - low));
            if far(a) < far(b) {
                high = b;
            } else {
                low = a;
            }
        }
        0.5 * (low + high)
    }
}

/// Returns the distances of two poses in XYZ, ABC and UVW.
pub(crate) fn distances(a: &[f64; AXES], b: &[f64; AXES]) -> [f64; 3] {
    [0, 3, 6].map(|k| square(sub3(group(a, k), group(b, k))).sqrt())
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

fn dot3(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn square(a: [f64; 3]) -> f64 {
    dot3(a, a)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
