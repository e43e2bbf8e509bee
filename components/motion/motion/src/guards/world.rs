//! Realtime. Conditions for moving axes: the kinematics must have a pose for the joints, and for that pose the same
//! joints. Otherwise the first cycle in axes would move a joint elsewhere at once.

use crate::{commands::command::Mode, commands::refusal::Refusal, setup::Places, state::State};
use hal_component::KinematicsKind;
use hal_safety::Event;
use libm::fabs;

/// Rounding error of a position, relative to it.
const ROUNDING: f64 = 1e-9;

impl State {
    /// Refuses a mode in which axes move if they cannot.
    pub(crate) fn needs_world(&self, mode: Mode) -> Result<(), Refusal> {
        if mode == Mode::Free {
            return Ok(());
        }
        let identity = self.kinematics.kind() == KinematicsKind::Identity;
        if !identity && !self.is_all_homed() {
            return Err(Refusal::new(match mode {
                Mode::Coord => "all joints must be homed before going into coordinated mode",
                Mode::Free | Mode::Teleop => {
                    "all joints must be homed before going into teleop mode"
                }
            }));
        }
        self.needs_pose()
    }

    /// Refuses if forward and inverse kinematics do not lead back to the joints.
    pub(crate) fn needs_pose(&self) -> Result<(), Refusal> {
        let places = self.places();
        let mut pose = self.whole_pose();
        let found = match self.kinematics.kind() {
            // Only the last commanded pose can be that of the joints.
            KinematicsKind::InverseOnly => true,
            _ => self.kinematics.forward(&places, &mut pose).is_ok(),
        };
        let mut back = places;
        if !found || !pose.iter().all(|p| p.is_finite()) {
            return Err(self.no_pose(&places));
        }
        if self.kinematics.inverse(&pose, &mut back).is_err() {
            return Err(self.no_pose(&places));
        }
        for (n, (place, answer)) in places.iter().zip(&back).enumerate() {
            if self.is_elsewhere(n, *place, *answer) {
                return Err(Refusal::at(
                    "the axes cannot move: joint {} is at {}, but the kinematics put it at {}",
                    n,
                    *place,
                    *answer,
                ));
            }
        }
        Ok(())
    }

    /// Names the joint that is farthest from its position according to the last pose, or the first joint.
    fn no_pose(&self, places: &Places) -> Refusal {
        let mut last = *places;
        // Without a solution they stay, and the first joint is named.
        let _solved = self.kinematics.inverse(&self.whole_pose(), &mut last);
        let (mut n, mut place, mut way) = (0, 0.0, -1.0);
        for (i, (joint, (at, last))) in self.joints.iter().zip(places.iter().zip(&last)).enumerate()
        {
            let farther = fabs(at - last) > way;
            if joint.active && !joint.extra && farther {
                (n, place, way) = (i, *at, fabs(at - last));
            }
        }
        Refusal::at(
            "the axes cannot move: the kinematics have no pose for joint {} at {}",
            n,
            place,
            0.0,
        )
    }

    /// Returns to free mode when a machine whose axes cannot move is switched on, or gains a joint, in a mode that
    /// moves axes.
    pub(crate) fn leave_world(&mut self) {
        let Err(why) = self.needs_world(self.mode()) else { return };
        why.say(&self.say);
        self.say.warn("the machine is in free mode now", &[]);
        let facts = self.facts();
        self.machine.on(Event::NoPlace, &facts);
        self.sync(why.text());
    }

    /// Returns whether a joint would have to move farther at once than it can from rest in one cycle.
    fn is_elsewhere(&self, n: usize, place: f64, answer: f64) -> bool {
        let Some(joint) = self.joints.get(n).filter(|j| j.active && !j.extra) else {
            return false;
        };
        let c = &joint.config;
        let start = c.max_acceleration * self.dt * self.dt;
        let step = c.max_velocity * self.dt;
        let near = if start < step { start } else { step };
        let near = near + ROUNDING * fabs(place);
        let is_near = fabs(answer - place) <= near;
        !is_near
    }
}
