//! Realtime. Intersections of circles and spheres: a two-link arm in a plane, and trilateration.

use crate::rotation::{Vector, is_straight};
use hal_component::{Solved, Unsolved};
use libm::{acos, atan2, fabs, sqrt};

/// Sine of 60 degrees.
pub(crate) const SIN_60: f64 = 0.866_025_403_784_438_6;

/// Elbow angle of a two-link arm that reaches a point in its plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend {
    /// Elbow angle in radians, 0 to π; the second solution is its negative.
    pub(crate) elbow: f64,
    pub(crate) solved: Solved,
}

/// Returns the elbow angle at which two links reach a distance, given as its square (law of cosines; Craig,
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

/// Returns the direction of the first link in radians, for a point in the plane and an elbow angle.
pub(crate) fn shoulder(x: f64, y: f64, first: f64, second: f64, elbow: f64) -> f64 {
    let (s, c) = (libm::sin(elbow), libm::cos(elbow));
    atan2(y, x) - atan2(second * s, first + second * c)
}

/// Limits a sine or cosine to 1 in magnitude, in case rounding has carried it beyond.
pub(crate) fn within_one(x: f64) -> f64 {
    if fabs(x) <= 1.0 { x } else { libm::copysign(1.0, x) }
}

/// Relative rounding error allowed before a point counts as out of reach.
const ROUNDING: f64 = 1e-12;

/// Returns the two points at given distances from three centres; they are mirror images at the plane of the centres.
/// The first one is on the side from which the centres run counter-clockwise (Manolakis, "Efficient solution and
/// performance analysis of 3-D position estimation by trilateration", 1996).
pub(crate) fn meet(
    centres: &[Vector; 3],
    radii: [f64; 3],
) -> Result<([Vector; 2], Solved), Unsolved> {
    let [p1, p2, p3] = centres;
    let (b, c) = (p2 - p1, p3 - p1);
    let d = b.norm();
    let normal = b.cross(&c);
    let area = normal.norm();
    // Collinear or coincident centres leave a circle of solutions.
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

/// Relative area below which a triangle counts as degenerate.
const SLIM: f64 = 1e-9;
