//! Refusal of moves without joint positions, or through a singularity.

use super::{Planner, count};
use crate::{
    curve::Curve,
    error::Error,
    kinematics::{CELL, Kinematics, joint_bounds},
    segment::Segment,
    speed::Shares,
};

impl<K: Kinematics> Planner<K> {
    /// Refuses a segment that passes a pose without joint positions, or a singularity: a part of it where a joint allows
    /// less than a hundredth of the feed and of the speed elsewhere on the segment.
    pub(super) fn check_reach(&self, segment: &Segment) -> Result<(), Error> {
        let line = segment.line;
        let pieces = count(segment.length / CELL);
        let width = segment.length / f64::from(pieces);
        let feed = segment.feed.min(self.machine.top_speed());
        let (mut highest, mut lowest, mut tightest) = (0.0_f64, f64::INFINITY, 0);
        for k in 0..pieces {
            let (from, to) = (width * f64::from(k), width * f64::from(k + 1));
            let joints = joint_bounds(&self.kinematics, &segment.curve, from, to)
                .map_err(|(joint, place)| Error::Unreachable { line, joint, place })?;
            let bounds = segment.curve.bounds(from, to, segment.lead);
            let plain = self.law.allowed(&bounds, None, feed, Shares::MOVE).speed;
            let speed = self.law.allowed(&bounds, Some(&joints), feed, Shares::MOVE).speed;
            highest = highest.max(speed);
            if speed < 0.01 * plain && speed < lowest {
                lowest = speed;
                tightest = self.law.tightest_joint(&joints);
            }
        }
        if lowest < 0.01 * highest {
            return Err(Error::Singular { line, joint: tightest });
        }
        Ok(())
    }

    /// Returns true if the joints have positions everywhere on a curve of this length, cut into so many cells.
    pub(super) fn has_joints(&self, curve: &Curve, length: f64, pieces: u16) -> bool {
        let pieces = pieces.max(count(length / CELL));
        let width = length / f64::from(pieces);
        self.direct
            || (0..pieces).all(|k| {
                let (from, to) = (width * f64::from(k), width * f64::from(k + 1));
                joint_bounds(&self.kinematics, curve, from, to).is_ok()
            })
    }
}
