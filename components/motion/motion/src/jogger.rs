//! Realtime. Jogging of a joint or an axis, by a command or a wheel.

use crate::simple_tp::SimpleTp;
use hal_component::{In, TicketHandle};
use libm::fabs;

/// Limits of a jog: travel, velocity, acceleration and jerk.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TravelLimits {
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) max_vel: f64,
    pub(crate) max_acc: f64,
    pub(crate) max_jerk: f64,
}

impl TravelLimits {
    /// Narrows the limits of an axis at `pos` to those of a joint at `joint_pos` that moves by `slope` per unit of the
    /// axis.
    pub(crate) fn narrow(&mut self, joint: &Self, joint_pos: f64, pos: f64, slope: f64) {
        let a = pos + (joint.min - joint_pos) / slope;
        let b = pos + (joint.max - joint_pos) / slope;
        let (min, max) = if slope > 0.0 { (a, b) } else { (b, a) };
        if min > self.min {
            self.min = min;
        }
        if max < self.max {
            self.max = max;
        }
        let (vel, acc) = (joint.max_vel / fabs(slope), joint.max_acc / fabs(slope));
        if vel < self.max_vel {
            self.max_vel = vel;
        }
        if acc < self.max_acc {
            self.max_acc = acc;
        }
        let jerk = joint.max_jerk / fabs(slope);
        if jerk < self.max_jerk {
            self.max_jerk = jerk;
        }
    }

    /// Clamps a target to the limits. A position that is already beyond a limit causes no motion back towards it.
    fn bound(&self, target: f64, from: f64) -> f64 {
        if target > from {
            if target <= self.max {
                target
            } else if self.max > from {
                self.max
            } else {
                from
            }
        } else if target < from {
            if self.min <= target {
                target
            } else if self.min < from {
                self.min
            } else {
                from
            }
        } else {
            from
        }
    }
}

/// Pins of a jog wheel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelPins {
    pub(crate) counts: In<i32>,
    pub(crate) enable: In<bool>,
    pub(crate) scale: In<f64>,
    pub(crate) vel_mode: In<bool>,
    pub(crate) accel_fraction: In<f64>,
}

/// Source of the current motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum By {
    /// Nothing.
    #[default]
    Nobody,
    /// A command.
    Command,
    /// The wheel.
    Wheel,
    /// Homing.
    Homing,
}

/// A planner and the source that drives it.
#[derive(Debug, Default)]
pub(crate) struct Jogger {
    pub(crate) tp: SimpleTp,
    pub(crate) by: By,
    ticket: Option<TicketHandle>,
    old_counts: Option<i32>,
}

impl Jogger {
    /// Moves to a target at a speed; replaces any previous motion.
    pub(crate) fn set_target(
        &mut self,
        target: f64,
        speed: f64,
        limits: &TravelLimits,
        by: By,
        ticket: Option<TicketHandle>,
    ) {
        self.fail_ticket("superseded by another jog");
        self.tp.target = limits.bound(target, self.tp.pos);
        self.tp.max_vel = if speed < limits.max_vel { speed } else { limits.max_vel };
        self.tp.max_acc = limits.max_acc;
        self.tp.max_jerk = limits.max_jerk;
        self.tp.enable = true;
        self.tp.active = true;
        self.by = by;
        self.ticket = ticket;
    }

    /// Brakes; the ticket is done at rest.
    pub(crate) fn stop(&mut self, why: &'static str, ticket: Option<TicketHandle>) {
        self.tp.enable = false;
        self.fail_ticket(why);
        if self.tp.active {
            self.ticket = ticket;
        } else if let Some(ticket) = ticket {
            ticket.done();
        }
    }

    /// Lowers the speed limit of the current motion.
    pub(crate) fn slow_to(&mut self, velocity: f64) {
        if velocity < self.tp.max_vel {
            self.tp.max_vel = velocity;
        }
    }

    /// Brakes without a ticket.
    pub(crate) const fn brake(&mut self) {
        self.tp.enable = false;
    }

    /// Stops at a position at once.
    pub(crate) fn reset(&mut self, pos: f64, why: &'static str) {
        self.tp.reset(pos);
        self.by = By::Nobody;
        self.fail_ticket(why);
    }

    fn fail_ticket(&mut self, why: &'static str) {
        if let Some(ticket) = self.ticket.take() {
            ticket.fail(why);
        }
    }

    /// Runs one cycle.
    pub(crate) fn step(&mut self, dt: f64) {
        self.tp.step(dt);
        if !self.tp.active {
            self.by = By::Nobody;
            if let Some(ticket) = self.ticket.take() {
                ticket.done();
            }
        }
    }

    /// Returns whether the current motion is a jog, by a command or the wheel.
    pub(crate) const fn is_jog(&self) -> bool {
        matches!(self.by, By::Command | By::Wheel)
    }

    /// Returns whether the wheel has turned since it was last read.
    pub(crate) fn is_turned(&self, pins: &WheelPins) -> bool {
        self.old_counts.is_some_and(|old| old != pins.counts.get()) && pins.enable.get()
    }

    /// Returns whether the wheel is where it was when it was last read.
    pub(crate) fn has_counted(&self, counts: In<i32>) -> bool {
        self.old_counts == Some(counts.get())
    }

    /// Reads the wheel, and moves by its counts if that is allowed.
    pub(crate) fn wheel(
        &mut self,
        pins: &WheelPins,
        allowed: bool,
        limits: impl Fn() -> TravelLimits,
    ) {
        let counts = pins.counts.get();
        let old = self.old_counts.replace(counts).unwrap_or(counts);
        let distance = f64::from(counts.wrapping_sub(old)) * pins.scale.get();
        let free = matches!(self.by, By::Nobody | By::Wheel);
        if !allowed || !free || !pins.enable.get() || distance == 0.0 || !distance.is_finite() {
            return;
        }
        let fraction = pins.accel_fraction.get();
        let fraction = if (0.0..=1.0).contains(&fraction) { fraction } else { 1.0 };
        let limits = limits();
        let mut limits = TravelLimits { max_acc: limits.max_acc * fraction, ..limits };
        if limits.max_acc <= 0.0 {
            return;
        }
        if self.tp.active && limits.max_acc < self.tp.max_acc {
            // The axis must still be able to brake before a limit.
            limits.max_acc = self.tp.max_acc;
        }
        let mut target = self.tp.target + distance;
        if pins.vel_mode.get() {
            // The target leads by at most the braking distance from full speed.
            let lead = limits.max_vel * limits.max_vel / (2.0 * limits.max_acc);
            let way = target - self.tp.pos;
            if fabs(way) > lead {
                target = self.tp.pos + if way > 0.0 { lead } else { -lead };
            }
        }
        self.set_target(target, limits.max_vel, &limits, By::Wheel, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_stay_within_the_limits() {
        for (min, max, from, target, expected) in [
            (-50.0, 200.0, 0.0, 10.0, 10.0),
            (-50.0, 200.0, 0.0, f64::INFINITY, 200.0),
            (-50.0, 200.0, 0.0, -60.0, -50.0),
            // Already beyond a limit: only motion towards the limit.
            (-50.0, 200.0, 210.0, 220.0, 210.0),
            (-50.0, 200.0, 210.0, 205.0, 205.0),
            (-50.0, 200.0, -60.0, -70.0, -60.0),
            // Crossed or NaN limits forbid nothing.
            (20.0, -20.0, 0.0, 10.0, 0.0),
            (f64::NAN, f64::NAN, 0.0, 10.0, 0.0),
            (-50.0, 200.0, 0.0, f64::NAN, 0.0),
        ] {
            let limits = TravelLimits { min, max, max_vel: 1.0, max_acc: 1.0, max_jerk: 1.0 };
            assert_eq!(limits.bound(target, from), expected, "{min} {max} {from} {target}");
        }
    }
}
