//! Realtime. External offset of one axis, added by pins to its position within a fraction of its limits.

use crate::{jogger::TravelLimits, setup::is_zero, simple_tp::SimpleTp};
use hal_component::In;

/// External offset of one axis.
#[derive(Debug, Default)]
pub(crate) struct Offset {
    pub(crate) tp: SimpleTp,
    /// Requested offset, regardless of limits.
    request: f64,
    /// Offset of the previous cycle.
    last: f64,
    counts: Option<i32>,
    /// True if a limit keeps the offset from its request.
    is_limited: bool,
}

/// Pins of an external offset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OffsetPins {
    pub(crate) enable: In<bool>,
    pub(crate) clear: In<bool>,
    pub(crate) counts: In<i32>,
    pub(crate) scale: In<f64>,
}

impl Offset {
    /// Reads the pins.
    pub(crate) fn ask(&mut self, pins: &OffsetPins, allowed: bool) {
        let counts = pins.counts.get();
        let old = self.counts.replace(counts).unwrap_or(counts);
        if pins.clear.get() {
            self.request = 0.0;
        } else if allowed && pins.enable.get() {
            let more = f64::from(counts.wrapping_sub(old)) * pins.scale.get();
            if (self.request + more).is_finite() {
                self.request += more;
            }
        }
    }

    /// Moves the offset one cycle towards its request, as far as the limits permit.
    pub(crate) fn step(&mut self, limits: &TravelLimits, dt: f64) {
        self.last = self.tp.pos;
        let mut target = self.request;
        // Crossed limits are both ignored.
        if target > limits.max && limits.max >= limits.min {
            target = limits.max;
        } else if target < limits.min && limits.max >= limits.min {
            target = limits.min;
        }
        self.is_limited = target != self.request;
        self.tp.target = target;
        self.tp.max_vel = limits.max_vel;
        self.tp.max_acc = limits.max_acc;
        self.tp.max_jerk = limits.max_jerk;
        self.tp.enable = true;
        self.tp.step_exactly(dt);
    }

    /// Brakes, and stays.
    pub(crate) fn brake(&mut self, dt: f64) {
        self.last = self.tp.pos;
        self.tp.enable = false;
        self.tp.step_exactly(dt);
        self.request = self.tp.pos;
    }

    /// Reduces the motion of this cycle to a part.
    pub(crate) fn slow_down(&mut self, factor: f64) {
        self.tp.slow_down(self.last, factor);
    }

    /// Stops the offset where it was in the previous cycle.
    pub(crate) fn hold(&mut self) {
        self.set(self.last);
    }

    /// Sets the offset and its request to a value, at rest.
    pub(crate) fn set(&mut self, place: f64) {
        (self.request, self.last, self.is_limited) = (place, place, false);
        self.tp.reset(place);
    }

    /// Returns whether the offset moved in this cycle.
    pub(crate) fn moves(&self) -> bool {
        self.tp.pos.to_bits() != self.last.to_bits()
    }

    /// Returns whether an offset is applied.
    pub(crate) fn is_there(&self) -> bool {
        !is_zero([self.tp.pos, self.tp.vel])
    }

    /// Returns whether there is no offset, and none is requested.
    pub(crate) fn is_unused(&self) -> bool {
        self.request == 0.0 && !self.is_there()
    }

    /// Returns whether nothing has changed: no offset is there or was there, none is requested, and the counts are the same.
    pub(crate) fn rests_at_zero(&self, counts: In<i32>) -> bool {
        let is_at_zero = is_zero([self.request, self.tp.pos, self.tp.vel, self.last]);
        is_at_zero & !self.is_limited & !self.tp.enable && self.counts == Some(counts.get())
    }

    /// Returns whether a limit keeps the offset from its request.
    pub(crate) const fn is_limited(&self) -> bool {
        self.is_limited
    }

    /// Returns the offset that is requested and the one that is applied.
    pub(crate) const fn values(&self) -> [f64; 2] {
        [self.request, self.tp.pos]
    }
}
