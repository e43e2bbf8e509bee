//! Realtime. Switch-off after a gap in time (the process or the computer stood still, or the threads were stopped and
//! started), and when a driver has lost its hardware. What the machine did meanwhile is unknown, and nothing may go on by
//! itself.

use super::interlock::Lockout;
use crate::{joint::Joint, pins::Pins, state::State};
use hal_safety::Event;

/// Reason for which nobody knows what the machine did for a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unseen {
    /// The process or the computer stood still, or the threads were stopped and started.
    Gap,
    /// A driver lost its hardware: what it counts may be more than what moved.
    Hardware,
}

impl Unseen {
    const fn cause(self) -> &'static str {
        match self {
            Self::Gap => "motion stopped: the process stood still",
            Self::Hardware => Lockout::Hardware.cause(),
        }
    }

    const fn lost(self) -> &'static str {
        match self {
            Self::Gap => {
                "joint {} is no longer homed: it moved when the process stood still, and only its own \
                 steps are counted"
            }
            Self::Hardware => {
                "joint {} is no longer homed: it moved when a driver lost its hardware, and only its own \
                 steps are counted"
            }
        }
    }
}

impl State {
    /// Switches the machine off after a time that nobody saw. A joint that moved then, and whose position no sensor
    /// measures, is no longer homed: a motor loses steps when their pulses end at speed.
    pub(crate) fn note_unseen(&mut self, unseen: Unseen, pins: &Pins) {
        let measured = pins.measured.iter().enumerate().filter(|(_, m)| m.get());
        self.open_loop = measured.fold(u32::MAX, |open, (n, _)| open & !(1 << n));
        let homed = bits(&self.joints, |j| j.homing.homed);
        if self.is_on() {
            self.say.error(unseen.cause(), &[]);
            self.stops.keep(self.now_ns, unseen.cause());
        }
        let moved = bits(&self.joints, |j| j.active && j.vel_cmd != 0.0) & self.open_loop;
        let lost = self.tell(Event::Gap, unseen.cause()).unhome;
        for n in (0..self.joints.len()).filter(|n| (lost & homed & moved) >> n & 1 == 1) {
            self.say.error(unseen.lost(), &[n as f64]);
        }
    }
}

fn bits(joints: &[Joint], is: impl Fn(&Joint) -> bool) -> u32 {
    joints.iter().enumerate().filter(|(_, j)| is(j)).fold(0, |bits, (n, _)| bits | 1 << n)
}
