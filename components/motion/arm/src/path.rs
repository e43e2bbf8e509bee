//! Targets of a tool along a part, and the samples between them.

use crate::{
    apt::{Motion, Point},
    frame::Frame,
    rotation::{Matrix, Vector, about, to_vector},
};
use libm::ceil;

/// Largest number of samples of a path.
pub const MAX_SAMPLES: usize = 400_000;
/// Largest distance between samples, in millimetres.
const STEP: f64 = 1.0;
/// Largest angle between samples, in degrees.
const TURN: f64 = 1.0;
/// Sine of the angle between the tool and the X axis below which Y replaces it.
const PARALLEL: f64 = 0.017_452;

/// Kind of a target.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// Point before the first one, back along the tool.
    Approach,
    /// Point of the part.
    Point,
    /// Point after the last one, back along the tool.
    Retract,
    /// Pause of the path: the tool goes back along itself, changes its configuration, and returns.
    Change,
}

/// Place that the tool's tip goes to in a straight line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Target {
    /// Kind.
    pub kind: Kind,
    /// Number of the point of the part, from 1.
    pub point: usize,
    /// Line of the file, from 1.
    pub line: u32,
    /// Tip relative to the arm's base; Z points out of the arm.
    pub tip: Frame,
    /// Feed in millimetres per second; infinite for a rapid motion.
    pub feed: f64,
}

/// Pose between two targets, or at the second.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sample {
    /// Index of the target that the motion leads to.
    pub target: usize,
    /// True at the target.
    pub is_target: bool,
    /// Tip relative to the arm's base.
    pub tip: Frame,
    /// Distance from the sample before, in millimetres.
    pub length: f64,
}

/// Returns the tip moved back along the tool.
#[must_use]
pub fn backed(tip: &Frame, by: f64) -> Frame {
    Frame { origin: tip.point(&Vector::new(0.0, 0.0, -by)), turn: tip.turn }
}

/// Returns the targets of a part in a frame. `away` is the distance of the first and last target from the part, along
/// the tool; `feed` applies to points before any feed is given.
#[must_use]
pub fn targets(points: &[Point], frame: &Frame, away: f64, feed: f64) -> Vec<Target> {
    let mut out = Vec::new();
    let mut last = Vector::x();
    for (point, p) in (1..).zip(points) {
        let turn = held(&(frame.turn * -p.axis), &last);
        last = turn.column(0).into();
        let feed = match p.motion {
            Motion::Start | Motion::Rapid => f64::INFINITY,
            Motion::Feed(given) => given.unwrap_or(feed),
        };
        let tip = Frame { origin: frame.point(&p.place), turn };
        out.push(Target { kind: Kind::Point, point, line: p.line, tip, feed });
    }
    let ends = (out.first().copied(), out.last().copied());
    if let (Some(first), Some(last)) = ends {
        let tip = backed(&first.tip, away);
        out.insert(0, Target { kind: Kind::Approach, tip, ..first });
        let tip = backed(&last.tip, away);
        out.push(Target { kind: Kind::Retract, tip, feed: f64::INFINITY, ..last });
    }
    out
}

/// Returns the rotation of a tool along Z whose X axis is as near as possible to the last one.
fn held(z: &Vector, last: &Vector) -> Matrix {
    let reference = if z.cross(last).norm() > PARALLEL { *last } else { Vector::y() };
    let x = (reference - z * reference.dot(z)).normalize();
    Matrix::from_columns(&[x, z.cross(&x), *z])
}

/// Returns the poses along the targets, at most a millimetre and a degree apart; `None` if they are too many.
#[must_use]
pub fn samples(targets: &[Target]) -> Option<Vec<Sample>> {
    let first = targets.first()?;
    let mut out = vec![Sample { target: 0, is_target: true, tip: first.tip, length: 0.0 }];
    for (n, pair) in targets.windows(2).enumerate() {
        let [from, to] = pair else { break };
        for (tip, length) in between(&from.tip, &to.tip, MAX_SAMPLES - out.len())? {
            out.push(Sample { target: n + 1, is_target: false, tip, length });
        }
        if let Some(last) = out.last_mut() {
            last.is_target = true;
        }
    }
    Some(out)
}

/// Returns the poses from one to another without the first, each with its distance from the one before; `None` if there
/// are more than `most`.
pub(crate) fn between(from: &Frame, to: &Frame, most: usize) -> Option<Vec<(Frame, f64)>> {
    let way = to.origin - from.origin;
    let turn = to_vector(&(to.turn * from.turn.transpose()));
    let angle = turn.norm();
    let count = ceil(f64::max(way.norm() / STEP, angle.to_degrees() / TURN) - 1e-9).max(1.0);
    if count.is_nan() || count > most as f64 {
        return None;
    }
    let axis = if angle > 1e-12 { turn / angle } else { Vector::z() };
    let mut out = Vec::new();
    let mut n = 1.0;
    while n < count {
        let part = n / count;
        let turn = about(&axis, angle * part) * from.turn;
        out.push((Frame { origin: from.origin + way * part, turn }, way.norm() / count));
        n += 1.0;
    }
    out.push((*to, way.norm() / count));
    Some(out)
}
