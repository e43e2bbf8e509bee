//! Realtime. A single axis: jogs, homing and the end of jogs under velocity, acceleration and jerk.
//!
//! The goal may change in any period. The input accelerates and brakes with constant acceleration; a moving average
//! behind it limits the jerk, as it does on a path. Between acceleration and deceleration the input cruises for as long
//! as the average looks back. A move that reaches its acceleration takes the least possible time, but for 5 periods; a
//! shorter move takes up to two lengths of the average more.

use crate::{error::Error, machine::Limits, speed::MAX_SAMPLES};

/// Shares of velocity, acceleration and jerk in use, so that rounding is no violation.
const SHARE: [f64; 3] = [1.0 - 1e-9, 1.0 - 1e-8, 1.0 - 1e-6];

/// Largest number of changes of acceleration in a period.
const MAX_EVENTS: u32 = 32;

/// Goal of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// Come to rest at a position, at no more than this speed.
    Position {
        /// Position.
        to: f64,
        /// Highest speed.
        speed: f64,
    },
    /// Move at a velocity; 0 comes to rest as soon as possible.
    Velocity(f64),
}

/// An axis that moves towards a goal.
#[derive(Clone, Debug)]
pub struct Axis {
    period: f64,
    top: f64,
    acceleration: f64,
    /// Time between acceleration and deceleration.
    pause: f64,
    samples: usize,
    /// Position and velocity of the input.
    x: f64,
    v: f64,
    /// Time since the last acceleration in the positive and in the negative direction.
    since: [f64; 2],
    ring: Box<[f64]>,
    next: usize,
    sum: f64,
    flat: usize,
    position: f64,
}

/// A step of the input: acceleration, and the time for which it lasts at most.
#[derive(Clone, Copy, Debug)]
struct Stage {
    a: f64,
    time: f64,
    /// Velocity at the end of that time.
    v: f64,
    /// Position at the end of that time, if it is known exactly.
    x: Option<f64>,
}

impl Axis {
    /// Axis at rest at a position, with a period in seconds.
    pub fn new(limits: Limits, period: f64, position: f64) -> Result<Self, Error> {
        let Limits { velocity, acceleration, jerk } = limits;
        for value in [velocity, acceleration, jerk] {
            if value.is_nan() || value < 1e-6 {
                return Err(Error::Limit { index: 0, value });
            }
        }
        if !(1e-5..=0.1).contains(&period) {
            return Err(Error::Setting { value: period });
        }
        if !position.is_finite() {
            return Err(Error::NotFinite { line: 0 });
        }
        let (top, mut a, j) =
            (velocity.min(1e9) * SHARE[0], acceleration.min(1e12) * SHARE[1], jerk * SHARE[2]);
        let (mut samples, mut pause) = (1, 0.0);
        if j.is_finite() {
            let time = (a / j).min((top / j).sqrt());
            let count = (time / period - 1e-9).ceil().max(2.0).min(f64::from(MAX_SAMPLES));
            a = a.min(j * count * period);
            pause = (count + 2.0) * period * (1.0 + 1e-9);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "2 to 2000"
            )]
            let whole = count as usize;
            samples = whole;
        }
        Ok(Self {
            period,
            top,
            acceleration: a,
            pause,
            samples,
            x: position,
            v: 0.0,
            since: [f64::INFINITY; 2],
            ring: vec![0.0; samples].into_boxed_slice(),
            next: 0,
            sum: 0.0,
            flat: samples,
            position,
        })
    }

    /// Advances by one period and returns the position at its end. A goal that is not finite is a stop.
    pub fn step(&mut self, goal: &Goal) -> f64 {
        let goal = match *goal {
            Goal::Position { to, speed } if to.is_finite() && speed > 0.0 => {
                Goal::Position { to, speed: speed.min(self.top) }
            }
            Goal::Velocity(v) if v.abs() > 0.0 => Goal::Velocity(v.abs().min(self.top).copysign(v)),
            Goal::Position { .. } | Goal::Velocity(_) => Goal::Velocity(0.0),
        };
        let start = self.x;
        let mut left = self.period;
        for _ in 0..MAX_EVENTS {
            if left <= 0.0 {
                break;
            }
            let stage = match goal {
                Goal::Position { to, speed } => self.toward(to, speed),
                Goal::Velocity(v) => self.at_velocity(v),
            };
            let time = stage.time.min(left);
            let whole = stage.time <= left;
            self.x += time * (self.v + 0.5 * stage.a * time);
            self.v = if whole { stage.v } else { self.v + stage.a * time };
            if whole && let Some(x) = stage.x {
                self.x = x;
            }
            let [up, down] = &mut self.since;
            *up = if stage.a > 0.0 { 0.0 } else { *up + time };
            *down = if stage.a < 0.0 { 0.0 } else { *down + time };
            left -= time;
        }
        self.average(self.x - start);
        self.position
    }

    /// Returns the position at the end of the last period.
    pub const fn position(&self) -> f64 {
        self.position
    }

    /// Returns true while the axis moves. At a turn it rests for a moment.
    pub const fn is_moving(&self) -> bool {
        self.v != 0.0 || self.flat < self.samples
    }

    /// Returns the position at which the axis comes to rest if it begins to stop now.
    pub fn stopping_position(&self) -> f64 {
        let since = if self.v > 0.0 { self.since[0] } else { self.since[1] };
        let wait = (self.pause - since).max(0.0);
        self.x + self.v * wait + 0.5 * self.v * self.v.abs() / self.acceleration
    }

    /// Acceleration in a direction, or the wait before it.
    fn push(&self, sign: f64, time: f64, v: f64) -> Stage {
        let since = if sign > 0.0 { self.since[1] } else { self.since[0] };
        if since < self.pause - 1e-12 {
            return self.cruise(self.pause - since);
        }
        Stage { a: sign * self.acceleration, time, v, x: None }
    }

    fn cruise(&self, time: f64) -> Stage {
        Stage { a: 0.0, time, v: self.v, x: None }
    }

    fn at_velocity(&self, v: f64) -> Stage {
        let by = v - self.v;
        if by == 0.0 {
            return self.cruise(f64::INFINITY);
        }
        self.push(by.signum(), by.abs() / self.acceleration, v)
    }

    fn toward(&self, to: f64, speed: f64) -> Stage {
        let a = self.acceleration;
        let d = (to - self.x).abs();
        // Rounding of places.
        let tiny = 4.0 * f64::EPSILON * to.abs().max(self.x.abs()) + 1e-15;
        let sign = if d > 0.0 { (to - self.x).signum() } else { self.v.signum() };
        let v = self.v * sign;
        if d == 0.0 && v == 0.0 {
            return self.cruise(f64::INFINITY);
        }
        // Away from the goal, or too fast to stop before it.
        let stopping = 0.5 * v * v / a;
        if v < 0.0 {
            return self.push(sign, -v / a, 0.0);
        }
        if v == 0.0 && d <= 16.0 * tiny {
            return Stage { a: 0.0, time: 0.0, v: 0.0, x: Some(to) };
        }
        if stopping >= d - tiny && v > 0.0 {
            let mut stage = self.push(-sign, v / a, 0.0);
            if stage.a != 0.0 && (stopping - d).abs() <= 4e-9 * d {
                // Within rounding of the way to the goal: exactly to the goal.
                let exact = 0.5 * v * v / d;
                stage = Stage { a: -sign * exact, time: v / exact, v: 0.0, x: Some(to) };
            }
            return stage;
        }
        if v > speed {
            return self.push(-sign, (v - speed) / a, speed * sign);
        }
        // The highest speed from which the axis can still pause and brake.
        let p = self.pause;
        let room = 4.0 * (d + stopping) / a;
        let peak = 0.5 * a * room / ((p * p + room).sqrt() + p);
        let most = peak.min(speed);
        if most > v * (1.0 + 1e-9) {
            return self.push(sign, (most - v) / a, most * sign);
        }
        self.cruise((d - stopping) / v)
    }

    /// Averages the travel over the last periods.
    fn average(&mut self, moved: f64) {
        self.flat = if moved == 0.0 && self.v == 0.0 { self.flat.saturating_add(1) } else { 0 };
        if let Some(slot) = self.ring.get_mut(self.next) {
            self.sum += moved - *slot;
            *slot = moved;
        }
        self.next += 1;
        if self.next >= self.samples {
            self.next = 0;
            self.sum = self.ring.iter().sum();
        }
        if self.flat >= self.samples {
            self.sum = 0.0;
            self.position = self.x;
            return;
        }
        #[expect(clippy::cast_precision_loss, reason = "at most 2000")]
        let mean = self.sum / self.samples as f64;
        self.position += mean;
    }
}
