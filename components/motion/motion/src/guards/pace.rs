//! Realtime. Reduction of axis movement to the velocity limits of all joints, for any kinematics and any number of
//! moving axes.

use crate::{commands::command::Mode, commands::refusal::Refusal, setup::Places, state::State};
use hal_component::Pose;
use libm::fabs;

/// Tolerance of a joint's step, relative to its longest permitted step.
const ROUNDING: f64 = 1e-7;

/// Maximum number of attempts per cycle: near singularities, joint motion is not proportional to axis motion.
const TRIES: i32 = 5;

impl State {
    /// Returns the joints for the pose of this cycle. If a joint would exceed its velocity limit, jogged
    /// axes and offsets are all reduced to the same part of their motion from `before`.
    pub(crate) fn paced(&mut self, before: &Pose, dt: f64) -> Result<Places, Refusal> {
        let mut places = self.solved()?;
        for n in 0..TRIES {
            let excess = self.excess(&places, dt);
            if excess <= 1.0 + ROUNDING {
                break;
            }
            // The previous reduction was not nearly enough.
            self.slow_down(libm::pow(excess, -f64::from(1 << n)), before);
            places = self.solved()?;
        }
        Ok(places)
    }

    /// Returns the joints for the pose with the offsets.
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

    /// Returns the largest of the joints' steps, relative to its permitted step; a joint above a limit that was lowered
    /// may keep its velocity while it brakes. A part below 1 is 1.
    fn excess(&self, places: &Places, dt: f64) -> f64 {
        let mut most = 1.0;
        for (joint, place) in self.joints.iter().zip(places) {
            if !joint.active || joint.extra {
                continue;
            }
            let (limit, step) = (joint.move_velocity, fabs(place - joint.pos_cmd));
            if step <= limit * dt {
                continue;
            }
            let now = fabs(joint.vel_cmd);
            // Slightly less, so that rounding does not accumulate.
            let braking = now * (1.0 - ROUNDING);
            let velocity = if braking > limit * (1.0 + ROUNDING) { braking } else { limit };
            let allowed = velocity * dt;
            if step > most * allowed {
                most = step / allowed;
            }
        }
        most
    }

    fn slow_down(&mut self, factor: f64, before: &Pose) {
        match self.mode() {
            // In coordinated mode the planner has proved the path; the offsets alone move less.
            Mode::Free | Mode::Coord => {}
            Mode::Teleop => {
                let places = self.pose.iter_mut().zip(before);
                for (axis, (pos, before)) in self.axes.iter_mut().zip(places) {
                    axis.teleop.tp.slow_down(*before, factor);
                    *pos = axis.teleop.tp.pos;
                }
            }
        }
        for axis in &mut self.axes {
            axis.offset.slow_down(factor);
        }
    }

    /// Makes current motions brake to limits that were lowered.
    pub(crate) fn lower_limits(&mut self) {
        for n in 0..self.axes.len() {
            if self.axes.get(n).is_some_and(|a| a.teleop.tp.active)
                && let Ok(limits) = self.jog_limits(n)
                && let Some(axis) = self.axes.get_mut(n)
            {
                axis.teleop.slow_to(limits.max_vel);
            }
        }
    }
}

const UNREACHABLE: Refusal = Refusal::new("the kinematics cannot go there");
