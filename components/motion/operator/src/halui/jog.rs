//! Jogs by buttons and joysticks.

use super::{groups::Jog, link::Machine};
use hal_component::{MotionCommand, motion_flags, motion_kind};

/// Kind of what jogs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Joint,
    Axis,
}

/// Speed of jogs, and the joystick values that do not count.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    pub(crate) speed: f64,
    pub(crate) deadband: f64,
}

/// State of the buttons and the joystick of a joint, of an axis, or of the selected one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Jogging {
    /// Number and velocity of the jog in progress.
    now: Option<(u32, f64)>,
}

impl Jogging {
    /// Begins, changes and ends jogs as the pins of `jog` and a joystick ask.
    pub(crate) fn step(
        &mut self,
        machine: &Machine,
        kind: Kind,
        n: u32,
        jog: &mut Jog,
        analog: f64,
        pace: Pace,
    ) {
        let wanted = match (jog.plus.get(), jog.minus.get()) {
            (true, false) => pace.speed,
            (false, true) => -pace.speed,
            (false, false) if analog.abs() > pace.deadband => analog * pace.speed,
            (true, true) | (false, false) => 0.0,
        };
        let wanted = (wanted != 0.0 && wanted.is_finite()).then_some((n, wanted));
        if wanted != self.now {
            // A command without room goes at the next look: until then the earlier jog is in progress.
            if let Some((old, _)) = self.now
                && wanted.is_none_or(|(new, _)| new != old)
                && !machine.motion(&command(kind, old, motion_kind::JOG_STOP))
            {
                return;
            }
            if let Some((new, speed)) = wanted
                && !machine.motion(&MotionCommand { speed, ..command(kind, new, motion_kind::JOG) })
            {
                return;
            }
            self.now = wanted;
        }
        let (plus, minus) = (jog.increment_plus.is_pressed(), jog.increment_minus.is_pressed());
        if plus == minus || self.now.is_some() {
            return;
        }
        let value = if plus { jog.increment.get() } else { -jog.increment.get() };
        let jog = command(kind, n, motion_kind::JOG);
        machine.motion(&MotionCommand { extent: 1, value, speed: pace.speed.abs(), ..jog });
    }
}

fn command(kind: Kind, index: u32, what: u32) -> MotionCommand {
    let flags = match kind {
        Kind::Joint => motion_flags::JOINT,
        Kind::Axis => motion_flags::AXIS,
    };
    MotionCommand { index, flags, ..MotionCommand::new(what) }
}
