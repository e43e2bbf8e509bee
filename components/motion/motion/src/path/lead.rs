//! Realtime. The plan of a thread or tap, before it moves: its speed, its lead-in and its run-out.

use crate::{
    commands::command::{Follows, Sync},
    commands::refusal::Refusal,
    spindle::Spindle,
};
use hal_trajectory::Limits;

const FAST: &str =
    "a pitch of {} at {} turns/min needs {} units/s along the path, and the axes allow {}";
const SHORT: &str = "the thread is {} long, and at {} turns/min it needs a lead-in of {} and a run-out of {}: begin it \
                     farther from the cut, or turn slower";
const SHALLOW: &str = "the tap is {} long, and at {} turns/min it needs a lead-in of {}: begin it farther from the hole, or \
                       turn slower";

/// Needs of a thread or tap at the speed of its spindle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// Limits along the path, and the length that is left.
    limits: Limits,
    length: f64,
    /// Servo period.
    dt: f64,
    pitch: f64,
    /// Turns per second, and the factor of the way out of a tap; 0 for a thread.
    turns: f64,
    back: f64,
}

impl Plan {
    pub(super) fn new(
        spindle: &Spindle,
        sync: &Sync,
        limits: Limits,
        length: f64,
        dt: f64,
    ) -> Self {
        let back = if let Follows::Tap { back } = sync.follows { back } else { 0.0 };
        Self { limits, length, dt, pitch: sync.pitch, turns: spindle.turns_a_second(), back }
    }

    /// Returns the way after which the axes move with the spindle.
    pub(super) fn lead_in(&self) -> f64 {
        self.limits.lead_in(self.pitch * self.turns, self.dt)
    }

    /// Refuses a speed along the path that the axes do not reach, at the largest pitch of a thread.
    pub(super) fn check_speed(&self, pitch: f64) -> Result<(), Refusal> {
        let factor = if self.back > 1.0 { self.back } else { 1.0 };
        let (turns, top) = (self.turns * factor, self.limits.velocity);
        let speed = pitch * turns;
        if speed < top {
            return Ok(());
        }
        Err(Refusal::with(FAST, [pitch, 60.0 * turns, speed, top]))
    }

    /// Refuses a length that is no more than the lead-in and the run-out.
    pub(super) fn check_length(&self) -> Result<(), Refusal> {
        let (lead_in, per_minute) = (self.lead_in(), 60.0 * self.turns);
        if self.back > 0.0 {
            if lead_in < self.length {
                return Ok(());
            }
            return Err(Refusal::with(SHALLOW, [self.length, per_minute, lead_in, 0.0]));
        }
        let run_out = self.limits.run_out(self.pitch * self.turns, self.dt);
        if lead_in + run_out < self.length {
            return Ok(());
        }
        Err(Refusal::with(SHORT, [self.length, per_minute, lead_in, run_out]))
    }

    /// Returns whether more is left than the run-out from this speed along the path.
    pub(super) fn is_in_cut(&self, speed: f64) -> bool {
        self.limits.run_out(speed, self.dt) < self.length
    }
}
