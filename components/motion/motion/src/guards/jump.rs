//! Realtime. Switch-off of a machine whose command would jump: it holds the last good commands, goes off, and reports
//! the joint, its intended step, and the source of the motion.

use crate::{
    commands::command::Mode, commands::refusal::rounded, guards::step::Jump, jogger::By,
    state::State,
};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Source of a joint's motion, in the order of [`WORDS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mover {
    Nothing,
    Jog,
    Wheel,
    Homing,
    TeleopJog,
    TeleopWheel,
    Move,
    ExternalOffset,
    Kinematics,
    PosthomeCmd,
    Correction,
}

/// Texts for a source: for tickets, for the operator, and by itself.
struct Words {
    cause: &'static str,
    say: &'static str,
    name: &'static str,
}

macro_rules! words {
    ($name:literal) => {
        Words {
            cause: concat!("a joint would have jumped: ", $name),
            say: concat!(
                "joint {} would jump from {} to {} in one cycle, where at most {} is allowed: ",
                $name,
                "; the machine is switched off"
            ),
            name: $name,
        }
    };
}

static WORDS: [Words; 11] = [
    words!("nothing should move it"),
    words!("a jog of the joint"),
    words!("the joint's jog wheel"),
    words!("homing"),
    words!("a jog of an axis"),
    words!("an axis's jog wheel"),
    words!("a coordinated move"),
    words!("an external offset"),
    words!("the kinematics, while no axis moves"),
    words!("its posthome-cmd"),
    words!("its backlash correction"),
];

fn words(mover: usize) -> &'static Words {
    WORDS.get(mover).unwrap_or(&WORDS[0])
}

/// Jump that switched the machine off, kept until the machine is switched on again.
#[derive(Debug, Default)]
pub(crate) struct LastJump {
    /// Number of the joint plus 1; 0 if there was no jump.
    joint: AtomicU32,
    mover: AtomicU32,
    from: AtomicU64,
    to: AtomicU64,
    allowed: AtomicU64,
}

/// Contents of a [`LastJump`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Told {
    pub(crate) joint: u32,
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) allowed: f64,
    pub(crate) mover: &'static str,
}

impl LastJump {
    fn set(&self, n: usize, mover: Mover, jump: Jump) {
        self.mover.store(mover as u32, Ordering::Relaxed);
        self.from.store(jump.from.to_bits(), Ordering::Relaxed);
        self.to.store(jump.to.to_bits(), Ordering::Relaxed);
        self.allowed.store(jump.allowed.to_bits(), Ordering::Relaxed);
        let joint = u32::try_from(n).map_or(0, |n| n.wrapping_add(1));
        self.joint.store(joint, Ordering::Release); // Pairs with `get`.
    }

    pub(crate) fn clear(&self) {
        self.joint.store(0, Ordering::Relaxed);
    }

    /// Control side: returns the jump, if one switched the machine off.
    pub(crate) fn get(&self) -> Option<Told> {
        // Pairs with `set`.
        let joint = self.joint.load(Ordering::Acquire).checked_sub(1)?;
        let number = |n: &AtomicU64| f64::from_bits(n.load(Ordering::Relaxed));
        Some(Told {
            joint,
            from: number(&self.from),
            to: number(&self.to),
            allowed: number(&self.allowed),
            mover: words(self.mover.load(Ordering::Relaxed) as usize).name,
        })
    }
}

impl State {
    /// Writes the commands of this cycle, or none of them if one would jump.
    pub(crate) fn put_out(&mut self, dt: f64) {
        let mut cause = None;
        for n in 0..self.joints.len() {
            let Some(joint) = self.joints.get(n) else { continue };
            let Err(jump) = joint.step_guard.judge(&joint.command(self.enabled), dt) else {
                continue;
            };
            let mover = if jump.is_of_correction { Mover::Correction } else { self.mover(n) };
            let words = words(mover as usize);
            let [from, to] = [jump.from, jump.to].map(|place| rounded(place, 1e9));
            self.say.error(words.say, &[n as f64, from, to, rounded(jump.allowed, 1e12)]);
            if cause.is_none() {
                self.last_jump.set(n, mover, jump);
            }
            cause.get_or_insert(words.cause);
            if let Some(joint) = self.joints.get_mut(n) {
                joint.error = true;
            }
        }
        if let Some(cause) = cause {
            self.turn_off(cause);
            self.joints.iter_mut().for_each(crate::joint::Joint::hold);
            self.sync(cause);
        } else {
            let enabled = self.enabled;
            for joint in &mut self.joints {
                let command = joint.command(enabled);
                joint.step_guard.put_out(&command, dt);
            }
        }
    }

    /// Returns the source of a joint's motion in this cycle.
    fn mover(&self, n: usize) -> Mover {
        let Some(joint) = self.joints.get(n) else { return Mover::Nothing };
        if joint.extra && joint.homing.homed {
            return Mover::PosthomeCmd;
        }
        let offset = self.axes.iter().any(|a| a.offset.moves());
        match self.mode {
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
