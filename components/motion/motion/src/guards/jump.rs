//! Realtime. Switch-off of a machine whose command would jump: it holds the last good commands, goes off, and reports
//! the joint, its intended step, and the source of the motion.

use crate::{
    commands::command::Mode,
    commands::refusal::rounded,
    guards::last_jump::{Mover, words},
    guards::step::{MotorCommand, Steps},
    jogger::By,
    setup::MAX_JOINTS,
    state::State,
};

impl State {
    /// Writes the commands of this cycle, or none of them if one would jump.
    pub(crate) fn put_out(&mut self, dt: f64) {
        let enabled = self.is_on();
        let mut passed = [(MotorCommand::default(), Steps::default()); MAX_JOINTS];
        for (joint, place) in self.joints.iter().zip(&mut passed) {
            let command = joint.command(enabled);
            match joint.step_guard.judge(&command, dt) {
                Ok(steps) => *place = (command, steps),
                Err(_) => return self.hold_back(dt),
            }
        }
        for (joint, (command, steps)) in self.joints.iter_mut().zip(&passed) {
            joint.step_guard.put_out(command, *steps);
        }
    }

    /// Switches off and keeps the last commands, because some would jump.
    #[cold]
    fn hold_back(&mut self, dt: f64) {
        let mut cause = None;
        for n in 0..self.joints.len() {
            let Some(joint) = self.joints.get(n) else { continue };
            let Err(jump) = joint.step_guard.judge(&joint.command(self.is_on()), dt) else {
                continue;
            };
            let mover = if jump.is_of_correction { Mover::Correction } else { self.mover(n) };
            let words = words(mover);
            let [from, to] = [jump.from, jump.to].map(|place| rounded(place, 1e9));
            let numbers = [from, to, rounded(jump.allowed, 1e12)];
            self.names.error(&self.say, &words.say, n, &numbers);
            if cause.is_none() {
                self.last_jump.set(n, mover, jump);
            }
            cause.get_or_insert(words.cause);
            if let Some(joint) = self.joints.get_mut(n) {
                joint.error = true;
            }
        }
        if let Some(cause) = cause {
            self.stop_for(cause);
            self.joints.iter_mut().for_each(crate::joint::Joint::hold);
            self.sync(cause);
        }
    }

    /// Returns the source of a joint's motion in this cycle.
    fn mover(&self, n: usize) -> Mover {
        let Some(joint) = self.joints.get(n) else { return Mover::Nothing };
        if joint.extra && joint.homing.homed {
            return Mover::PosthomeCmd;
        }
        let offset = self.axes.iter().any(|a| a.offset.moves());
        match self.mode() {
            Mode::Free => match joint.free.by {
                By::Command => Mover::Jog,
                By::Wheel => Mover::Wheel,
                By::Homing => Mover::Homing,
                By::Nobody if joint.homing.is_under_way() => Mover::Homing,
                By::Nobody => Mover::Nothing,
            },
            Mode::Teleop => {
                let jogged = |by| self.axes.iter().any(|a| a.teleop.by == by);
                if jogged(By::Command) {
                    Mover::TeleopJog
                } else if jogged(By::Wheel) {
                    Mover::TeleopWheel
                } else if offset {
                    Mover::ExternalOffset
                } else {
                    Mover::Kinematics
                }
            }
            Mode::Coord if self.path.has_moved() => Mover::Move,
            Mode::Coord if offset => Mover::ExternalOffset,
            Mode::Coord => Mover::Kinematics,
        }
    }
}
