//! Realtime. Movement in axes keeps to the velocity of every joint, however the kinematics turn it
//! into movement of joints and however many axes move at once.

use crate::{command::Mode, line::Places, refusal::Refusal, state::State};
use hal_component::Pose;
use libm::fabs;

/// A joint's step, as a part of the longest that it may make, that is left as it is.
const ROUNDING: f64 = 1e-7;

/// How often a cycle is computed again: near singular places joints are not in proportion to axes.
const TRIES: i32 = 5;

impl State {
    /// Finds the joints for the pose of this cycle. Where a joint would have to be faster than it
    /// may, axes, path and offsets go the same part of their way from `before`.
    pub(crate) fn paced(&mut self, before: &Pose, dt: f64) -> Result<Places, Refusal> {
        let mut places = self.solved()?;
        for n in 0..TRIES {
            let excess = self.excess(&places, dt);
            if excess <= 1.0 + ROUNDING {
                break;
            }
            // What did not suffice was too little by far.
            self.slow_down(libm::pow(excess, -f64::from(1 << n)), before);
            places = self.solved()?;
        }
        Ok(places)
    }

    /// The joints for the pose with the offsets.
    fn solved(&self) -> Result<Places, Refusal> {
        let mut places = self.places();
        if let Err(why) = self.kinematics.inverse(&self.whole_pose(), &mut places) {
            return Err(Refusal::new(why.text()));
        }
        let mut moved = self.joints.iter().zip(&places).filter(|(j, _)| j.active && !j.extra);
        if !moved.all(|(_, place)| place.is_finite()) {
            return Err(UNREACHABLE);
        }
        Ok(places)
    }

    /// The longest of the joints' steps, as a part of what each may make; a joint above a limit
    /// that was lowered may keep its velocity while it brakes.
    fn excess(&self, places: &Places, dt: f64) -> f64 {
        let mut most = 0.0;
        for (joint, place) in self.joints.iter().zip(places) {
            if !joint.active || joint.extra {
                continue;
            }
            let (limit, now) = (joint.config.max_velocity, fabs(joint.vel_cmd));
            // Less than it is, so that rounding adds up to nothing.
            let braking = now * (1.0 - ROUNDING);
            let velocity = if braking > limit * (1.0 + ROUNDING) { braking } else { limit };
            let excess = fabs(place - joint.pos_cmd) / (velocity * dt);
            if excess > most {
                most = excess;
            }
        }
        most
    }

    fn slow_down(&mut self, factor: f64, before: &Pose) {
        match self.mode {
            Mode::Free => {}
            Mode::Teleop => {
                let places = self.pose.iter_mut().zip(before);
                for (axis, (pos, before)) in self.axes.iter_mut().zip(places) {
                    axis.teleop.tp.slow_down(*before, factor);
                    *pos = axis.teleop.tp.pos;
                }
            }
            Mode::Coord => {
                if let Some(pose) = self.path.slow_down(factor) {
                    self.pose = pose;
                }
            }
        }
        for axis in &mut self.axes {
            axis.offset.slow_down(factor);
        }
    }

    /// Lets what moves already brake to limits that were lowered.
    pub(crate) fn lower_limits(&mut self) {
        for n in 0..self.axes.len() {
            if self.axes.get(n).is_some_and(|a| a.teleop.tp.active)
                && let Ok(room) = self.jog_room(n)
                && let Some(axis) = self.axes.get_mut(n)
            {
                axis.teleop.slow_to(room.max_vel);
            }
        }
        let Self { path, kinematics, joints, axes, shares, .. } = self;
        path.lower_limits(crate::line::Machine { kinematics, joints, axes, shares });
    }
}

const UNREACHABLE: Refusal = Refusal::new("the kinematics cannot go there");
