//! Realtime. The watchman of one joint: judges velocity, acceleration and jerk from the commands of its motor alone.
//!
//! The judge ([`hal_watchman`]) shares no code with the planners. A position is the motor's command without the
//! correction of backlash and screw, whose share of the limits is taken off. It is judged while the amplifier is on.
//! When an encoder's index or an absolute encoder gives the motor another zero, the judge begins again in that cycle.
//! Loss of enable in motion and `motion.jog-stop-immediate` stop a joint at once on purpose: they are counted, not
//! judged.

use crate::{commands::config::JointConfig, guards::step::MotorCommand, pins::JointPins};
use hal_watchman::{Limits, Report, Watchman, Worst};

/// Judge of one joint.
#[derive(Debug)]
pub(crate) struct JointWatch {
    judge: Watchman<1>,
    /// Configured limits, and the largest configured coordinate.
    configured: Limits,
    largest: f64,
    /// Limits in force. Lower ones wait until the joint is at rest, because it needs time to brake.
    limits: Limits,
    /// True if these are the configured ones.
    is_settled: bool,
    /// Largest coordinate in the computation of a command so far, and the period in seconds.
    size: f64,
    dt: f64,
    last: f64,
    pub(crate) moves: bool,
    pub(crate) is_on: bool,
    /// True if the encoder has another zero from this cycle on.
    has_new_zero: bool,
    /// Sum of the ratios that the pins show.
    shown: f64,
}

impl Default for JointWatch {
    fn default() -> Self {
        let limits = Limits { velocity: 0.0, acceleration: 0.0, jerk: f64::INFINITY };
        Self {
            judge: Watchman::new([limits], 1.0, 0.0),
            configured: limits,
            largest: 0.0,
            limits,
            is_settled: false,
            size: 0.0,
            dt: 0.0,
            last: 0.0,
            moves: false,
            is_on: false,
            has_new_zero: false,
            shown: 0.0,
        }
    }
}

impl JointWatch {
    /// Changes the limits to those that a configuration leaves to moves.
    pub(crate) fn configure(&mut self, c: &JointConfig) {
        self.configured = Limits {
            velocity: c.move_velocity(),
            acceleration: c.move_acceleration() * (1.0 + DEADBAND),
            jerk: c.move_jerk() * (1.0 + ROUNDING),
        };
        self.largest = finite(c.min_limit) + finite(c.max_limit);
        self.is_settled = false;
    }

    /// Judges a command that was written; returns false if it breaks a limit.
    pub(crate) fn step(&mut self, c: &MotorCommand, dt: f64, line: u32) -> bool {
        let at = c.position - c.correction;
        if !c.is_on {
            self.is_on = false;
            self.moves = false;
            return true;
        }
        let size = self.largest + c.offset.abs() + c.correction.abs();
        if !self.is_settled || size > self.size || dt.to_bits() != self.dt.to_bits() {
            let limits =
                if self.moves { higher(self.limits, self.configured) } else { self.configured };
            (self.limits, self.dt) = (limits, dt);
            self.is_settled = limits == self.configured;
            self.size = if size > self.size { size } else { self.size };
            self.judge.set_limits([limits], dt, self.size);
        }
        if !self.is_on {
            self.judge.rest_at(&[at]);
        } else if core::mem::take(&mut self.has_new_zero) {
            self.judge.restart();
        } else {
            self.moves = at.to_bits() != self.last.to_bits();
        }
        (self.is_on, self.has_new_zero, self.last) = (true, false, at);
        self.judge.step(&[at], line)
    }

    pub(crate) fn forget(&mut self) {
        self.judge.forget();
        self.shown = f64::NAN;
    }

    /// Writes the ratios, if they have changed; returns the highest one then.
    pub(crate) fn write_pins(&mut self, pins: &JointPins) -> Option<Worst> {
        // After a reset, the pins still show what was forgotten.
        if self.judge.is_calm() && !self.shown.is_nan() {
            return None;
        }
        let r = self.judge.report();
        let all = [r.velocity, r.acceleration, r.jerk];
        let sum = r.velocity.ratio + r.acceleration.ratio + r.jerk.ratio;
        if sum.to_bits() == self.shown.to_bits() {
            return None;
        }
        self.shown = sum;
        pins.watch_velocity.set(r.velocity.ratio);
        pins.watch_acceleration.set(r.acceleration.ratio);
        pins.watch_jerk.set(r.jerk.ratio);
        all.into_iter().reduce(|a, b| if b.ratio > a.ratio { b } else { a })
    }

    /// Accepts that the encoder has another zero from this cycle on.
    pub(crate) const fn change_zero(&mut self) {
        self.has_new_zero = true;
    }

    /// Returns the worst of each value so far.
    pub(crate) const fn report(&self) -> &Report {
        self.judge.report()
    }

    /// Accepts that the joint stops at once in this cycle.
    pub(crate) const fn stop(&mut self) {
        self.is_on = false;
    }
}

/// Returns the higher of each limit.
fn higher(a: Limits, b: Limits) -> Limits {
    let higher = |a: f64, b: f64| if a > b { a } else { b };
    Limits {
        velocity: higher(a.velocity, b.velocity),
        acceleration: higher(a.acceleration, b.acceleration),
        jerk: higher(a.jerk, b.jerk),
    }
}

/// Counters of the whole machine.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WatchCounters {
    pub(crate) violations: u32,
    pub(crate) hard_stops: u32,
    pub(crate) worst: f64,
    pub(crate) joint: i32,
    pub(crate) line: i32,
    /// True once the operator was informed of a violation.
    pub(crate) was_reported: bool,
}

/// Allowance for acceleration: a jog ends within a thousandth of one cycle's acceleration of its target, and the next
/// motion may begin at the target itself.
const DEADBAND: f64 = 1e-3;

/// Allowance for jerk, which magnifies the rounding of kinematics.
const ROUNDING: f64 = 1e-4;

fn finite(limit: f64) -> f64 {
    if limit.is_finite() { limit.abs() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 0.001;

    /// Returns whether the judge of a joint that rests at 0 accepts these commands.
    fn accepts(config: &JointConfig, places: &[f64]) -> bool {
        let mut watch = JointWatch::default();
        watch.configure(config);
        let command = |position| MotorCommand {
            position,
            offset: 0.0,
            correction: 0.0,
            feedback: position,
            max_velocity: config.max_velocity,
            is_on: true,
        };
        let mut all = [0.0; 4].iter().chain(places);
        all.all(|at| watch.step(&command(*at), DT, 0))
    }

    #[test]
    fn each_allowance_is_as_large_as_it_says() {
        let config = JointConfig { max_acceleration: 20.0, ..JointConfig::default() };
        // One cycle's acceleration from rest.
        let first = |ratio: f64| accepts(&config, &[ratio * 20.0 * DT * DT]);
        assert!(first(1.0) && first(1.0009));
        assert!(!first(1.0011));
        // One cycle's jerk from rest.
        let config = JointConfig { max_jerk: 1e4, ..config };
        let first = |ratio: f64| accepts(&config, &[ratio * 1e4 * DT * DT * DT]);
        assert!(first(1.0) && first(1.000_09));
        assert!(!first(1.000_11));
        // Velocity has none but for rounding.
        let config = JointConfig { max_acceleration: 1e4, ..JointConfig::default() };
        let at = |ratio: f64| accepts(&config, &[ratio * DT, 2.0 * ratio * DT]);
        assert!(at(1.0) && !at(1.000_01));
    }

    /// The larger the coordinates, the coarser their last digit: both limits count.
    #[test]
    fn rounding_of_large_coordinates_is_no_violation() {
        let digit = |at: f64| at * f64::EPSILON;
        for (min_limit, max_limit) in
            [(-1e6, 0.0), (0.0, 1e6), (-5e5, 5e5), (f64::NEG_INFINITY, 1e6)]
        {
            let config = JointConfig { min_limit, max_limit, ..JointConfig::default() };
            // A step of one digit of a coordinate at the limit, beside the greatest step: its acceleration is 1e-4 of the limit.
            let step = DT * DT * 1.001 + digit(1e6);
            assert!(accepts(&config, &[step]), "{min_limit} {max_limit}");
        }
        let config = JointConfig { min_limit: -1.0, max_limit: 1.0, ..JointConfig::default() };
        assert!(!accepts(&config, &[DT * DT * 1.001 + digit(1e6)]));
    }
}
