//! Realtime. Homing: a joint without a home switch is at home where it stands.

use crate::{
    jogger::{By, Room},
    joint::Joint,
};

/// Steps of homing that this way of homing takes; their numbers are those of `home-state`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Step {
    #[default]
    Idle = 0,
    Start = 1,
    SetSwitchPosition = 15,
    FinalMoveStart = 20,
    FinalMoveWait = 21,
}

/// How long a joint stands still before the final move, in seconds.
const REST: f64 = 0.1;

/// Where homing is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Homing {
    step: Step,
    rest: f64,
    pub(crate) homed: bool,
}

impl Homing {
    pub(crate) fn is_under_way(&self) -> bool {
        self.step != Step::Idle
    }

    /// As shown on `home-state`.
    pub(crate) const fn code(&self) -> i32 {
        self.step as i32
    }

    pub(crate) const fn begin(&mut self) {
        self.step = Step::Start;
        self.rest = 0.0;
        self.homed = false;
    }

    /// A joint that was being homed is not homed.
    pub(crate) const fn abort(&mut self) {
        self.step = Step::Idle;
    }
}

/// One cycle of homing.
pub(crate) fn cycle(joint: &mut Joint, dt: f64) {
    match joint.homing.step {
        Step::Idle => {}
        Step::Start => {
            if !joint.free.tp.active {
                joint.homing.step = Step::SetSwitchPosition;
            }
        }
        Step::SetSwitchPosition => {
            joint.rename(joint.config.home_offset);
            joint.homing.step = Step::FinalMoveStart;
        }
        Step::FinalMoveStart => {
            joint.homing.rest += dt;
            if joint.homing.rest >= REST {
                final_move(joint);
                joint.homing.step = Step::FinalMoveWait;
            }
        }
        Step::FinalMoveWait => {
            if !joint.free.tp.active {
                joint.homing.homed = true;
                joint.homing.step = Step::Idle;
            }
        }
    }
}

fn final_move(joint: &mut Joint) {
    let c = joint.config;
    let speed = if c.home_final_vel > 0.0 { c.home_final_vel } else { c.max_velocity };
    // HOME may lie anywhere: the limits hold once the joint is homed.
    let room = Room {
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        max_vel: c.max_velocity,
        max_acc: c.max_acceleration,
    };
    joint.free.go(c.home, speed, &room, By::Homing, None);
}
