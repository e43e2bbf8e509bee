//! Programs for testing motion planners.
//!
//! [`random`] makes programs of every [`Kind`] from a seed; [`named()`] lists well-known hard ones; [`shrink`] reduces a
//! program that fails to a small one that still fails. Moves are relative, so any part of a program is a program.
#![forbid(unsafe_code)]

mod named;
mod random;
mod rng;
mod shrink;

pub use named::{NAMES, named};
pub use random::{Kind, Options, random};
pub use rng::Rng;
pub use shrink::shrink;

/// Number of axes: X Y Z A B C U V W.
pub const AXES: usize = 9;

/// A program: a start pose and moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// Name of the kind or of the named program.
    pub name: &'static str,
    /// Seed that made it.
    pub seed: u64,
    /// Pose before the first move.
    pub start: [f64; AXES],
    /// Moves, in order.
    pub steps: Vec<Step>,
}

/// A move with its mode and feed.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Shape of the move.
    pub motion: Motion,
    /// Path control at the end of the move.
    pub mode: Mode,
    /// Programmed feed in units per second.
    pub feed: f64,
}

/// Shape of a move, relative to its start.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A straight line.
    Line {
        /// Displacement.
        by: [f64; AXES],
    },
    /// An arc or a helix.
    Arc {
        /// Centre, relative to the start and at its height.
        center: [f64; 3],
        /// Unit vector of the axis.
        normal: [f64; 3],
        /// Angle in radians, positive by the right-hand rule.
        angle: f64,
        /// Displacement along the axis.
        rise: f64,
        /// Displacement of A B C U V W.
        others: [f64; 6],
    },
    /// A B-spline or NURBS.
    Spline(Box<Spline>),
}

/// A B-spline (all weights equal) or NURBS, which starts at its first control point and ends at its last.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// Degree.
    pub degree: usize,
    /// Knots: as many as control points, and `degree` + 1 more.
    pub knots: Vec<f64>,
    /// Control points, relative to the first, each with its weight.
    pub points: Vec<([f64; AXES], f64)>,
}

impl Spline {
    /// Returns the control points for a start at `pose`, each with its weight.
    pub fn placed(&self, pose: &[f64; AXES]) -> Vec<([f64; AXES], f64)> {
        self.points.iter().map(|(by, weight)| (sum(pose, by), *weight)).collect()
    }
}

fn sum(a: &[f64; AXES], b: &[f64; AXES]) -> [f64; AXES] {
    let mut out = *a;
    for (x, d) in out.iter_mut().zip(b) {
        *x += d;
    }
    out
}

/// Path control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Come to rest at the end (G61.1).
    ExactStop,
    /// Stay on the path within the machine's exact tolerance (G61).
    Exact,
    /// Stay within this distance of the path (G64 P).
    Blend(f64),
}

impl Program {
    /// Returns the pose at the start of each move, and the last pose.
    pub fn poses(&self) -> Vec<[f64; AXES]> {
        let mut out = vec![self.start];
        let mut pose = self.start;
        for step in &self.steps {
            pose = step.motion.end(&pose);
            out.push(pose);
        }
        out
    }

    /// Returns the largest coordinate, radius or length that occurs.
    pub fn size(&self) -> f64 {
        let mut size = 1.0_f64;
        for (pose, step) in self.poses().iter().zip(&self.steps) {
            let values: &[f64] = match &step.motion {
                Motion::Line { by } => by,
                Motion::Spline(spline) => {
                    for (point, _) in spline.placed(pose) {
                        size = point.iter().fold(size, |m, x| m.max(x.abs()));
                    }
                    pose
                }
                Motion::Arc { center, angle, rise, .. } => {
                    let radius = center.iter().map(|x| x * x).sum::<f64>().sqrt();
                    size = size.max(radius * angle.abs()).max(rise.abs());
                    center
                }
            };
            let length = values.iter().map(|x| x * x).sum::<f64>().sqrt();
            size = pose.iter().fold(size, |m, x| m.max(x.abs())).max(length);
        }
        size
    }
}

impl Motion {
    /// Returns the pose after this move.
    pub fn end(&self, start: &[f64; AXES]) -> [f64; AXES] {
        let mut end = *start;
        match self {
            Self::Line { by } => end = sum(start, by),
            Self::Spline(spline) => {
                end = spline.points.last().map_or(*start, |(by, _)| sum(start, by));
            }
            Self::Arc { center: c, normal: n, angle, rise, others } => {
                // The arm turns around the axis: cos·arm + sin·(normal × arm).
                let arm = [-c[0], -c[1], -c[2]];
                let side = [
                    n[1] * arm[2] - n[2] * arm[1],
                    n[2] * arm[0] - n[0] * arm[2],
                    n[0] * arm[1] - n[1] * arm[0],
                ];
                let (sin, cos) = libm::sincos(*angle);
                let parts = c.iter().zip(arm).zip(side).zip(n);
                for (x, (((c, arm), side), n)) in end.iter_mut().zip(parts) {
                    *x += c + cos * arm + sin * side + rise * n;
                }
                for (x, d) in end.iter_mut().skip(3).zip(others) {
                    *x += d;
                }
            }
        }
        end
    }
}
