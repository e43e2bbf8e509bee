//! Realtime. Where circles and spheres meet: two links in a plane, and a point at three
//! distances.

use crate::rotation::{Vector, is_straight};
use hal_component::{Solved, Unsolved};
use libm::{acos, atan2, fabs, sqrt};

/// Sine of 60 degrees.
pub(crate) const SIN_60: f64 = 0.866_025_403_784_438_6;

/// The two links of an arm that reaches a point in its plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend {
    /// The angle at the elbow in radians, 0 to half a turn; the other way is its negative.
    pub(crate) elbow: f64,
    pub(crate) solved: Solved,
}

/// How far the elbow of two links must be bent to reach so far (the law of cosines; Craig,
/// Introduction to Robotics, section 4.4).
pub(crate) fn bend(reach_squared: f64, first: f64, second: f64) -> Result<Bend, Unsolved> {
    let cosine = (reach_squared - first * first - second * second) / (2.0 * first * second);
    let reaches = fabs(cosine) <= 1.0 + ROUNDING;
    if !reaches {
        return Err(Unsolved::Unreachable);
    }
    let elbow = acos(within_one(cosine));
    let solved = if is_straight(libm::sin(elbow)) { Solved::Singular } else { Solved::Regular };
    Ok(Bend { elbow, solved })
}

/// The direction of the first link in radians, for a point in the plane and a bend.
pub(crate) fn shoulder(x: f64, y: f64, first: f64, second: f64, elbow: f64) -> f64 {
    let (s, c) = (libm::sin(elbow), libm::cos(elbow));
    atan2(y, x) - atan2(second * s, first + second * c)
}

/// A sine or cosine that rounding has carried beyond 1.
pub(crate) fn within_one(x: f64) -> f64 {
    if fabs(x) <= 1.0 { x } else { libm::copysign(1.0, x) }
}

/// By how much rounding may carry a sum of squares beyond what can be reached.
const ROUNDING: f64 = 1e-12;

/// The two points at three distances from three points, mirrored at the plane of these; the
/// first one is on the side from which they turn counter-clockwise (Manolakis, "Efficient
/// solution and performance analysis of 3-D position estimation by trilateration", 1996).
pub(crate) fn meet(
    centres: &[Vector; 3],
    radii: [f64; 3],
) -> Result<([Vector; 2], Solved), Unsolved> {
    let [p1, p2, p3] = centres;
    let (b, c) = (p2 - p1, p3 - p1);
    let d = b.norm();
    let normal = b.cross(&c);
    let area = normal.norm();
    // Three points in a line, or at one place, leave a circle of answers.
    if !(d > 0.0 && area > SLIM * (b.norm_squared() + c.norm_squared())) {
        return Err(Unsolved::Undetermined);
    }
    let ex = b / d;
    let ez = normal / area;
    let ey = ez.cross(&ex);
    let (i, j) = (ex.dot(&c), ey.dot(&c));
    let [r1, r2, r3] = radii;
    let x = ((r1 - r2) * (r1 + r2) + d * d) / (2.0 * d);
    let y = ((r1 - r3) * (r1 + r3) + i * i + j * j - 2.0 * i * x) / (2.0 * j);
    let height = r1 * r1 - x * x - y * y;
    let size = r1 * r1 + x * x + y * y;
    let they_meet = height >= -ROUNDING * size;
    if !they_meet {
        return Err(Unsolved::Unreachable);
    }
    let z = if height > 0.0 { sqrt(height) } else { 0.0 };
    let solved = if is_straight(z / sqrt(size)) { Solved::Singular } else { Solved::Regular };
    let foot = p1 + ex * x + ey * y;
    Ok(([foot + ez * z, foot - ez * z], solved))
}

/// A triangle that slim is none.
const SLIM: f64 = 1e-9;
