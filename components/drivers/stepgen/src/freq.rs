//! Realtime. `stepgen.update-freq`: converts commands to step rates, once per slow period.

use crate::{
    capture::position,
    handover::{ASSUMED_NS, Base, Made, STEP, Wanted},
    params::{Params, Rounder},
    stepgen::Channel,
    types::Control,
};
use hal_component::{
    Error, Gives, In, Messages, ParamRo, ParamRw, Period, Takes, Touch, Update, Uses,
};

/// Function `stepgen.update-freq`.
#[derive(Touch)]
pub(crate) struct UpdateFreq {
    pub(crate) channels: Vec<Freq>,
    pub(crate) base: Takes<Base>,
}

impl Update for UpdateFreq {
    fn update(&mut self, period: Period) {
        if period.ns() < 1 {
            return;
        }
        let base_ns = self.base.ns();
        for channel in &mut self.channels {
            channel.update(period.secs(), base_ns);
        }
    }
}

/// State of one channel.
#[derive(Touch)]
pub(crate) struct Freq {
    command: In<f64>,
    enable: In<bool>,
    frequency: ParamRo<f64>,
    maxvel: ParamRw<f64>,
    maxaccel: ParamRw<f64>,
    scale: Scale,
    timing: Rounder,
    wanted: Gives<Wanted>,
    made: Takes<Made>,
    messages: Messages,
    #[state]
    number: f64,
    #[state]
    control: Control,
    #[state]
    speed: f64,
    #[state]
    last_command: f64,
    #[state]
    complained: bool,
}

impl Freq {
    pub(crate) fn new(
        c: &mut Channel<'_, '_>,
        control: Control,
        (enable, params, scale): (In<bool>, Params, Scale),
        (wanted, made): (Gives<Wanted>, Takes<Made>),
    ) -> Result<Self, Error> {
        const FREQUENCY: &str = "Current rate, in steps per second; negative: backward";
        const MAXVEL: &str = "Speed limit, in length units per second; 0 means the highest speed \
            that the pulses allow. A negative value becomes 0, and a value above that speed \
            becomes that speed";
        const MAXACCEL: &str = "Acceleration limit, in length units per second squared; 0: none. \
            A negative value becomes 0, one that changes nothing the largest that does";
        let (name, doc) = control.pin();
        Ok(Self {
            command: c.item(name, doc, 0.0)?,
            enable,
            frequency: c.item("frequency", FREQUENCY, 0.0)?,
            maxvel: c.item("maxvel", MAXVEL, 0.0)?,
            maxaccel: c.item("maxaccel", MAXACCEL, 0.0)?,
            scale,
            timing: Rounder::new(params),
            wanted,
            made,
            messages: c.b.messages(),
            number: c.number as f64,
            control,
            speed: 0.0,
            last_command: 0.0,
            complained: false,
        })
    }

    fn update(&mut self, dt: f64, base_ns: Option<i64>) {
        let scale = self.scale.get();
        let timing = self.timing.check(base_ns);
        if !self.enable.get() {
            let at = self.command.get() * scale;
            self.last_command = if at.is_finite() { at } else { self.last_command };
            self.speed = 0.0;
            self.frequency.set(0.0);
            self.wanted.stop();
            return;
        }
        let period = f64::from(timing.len) + f64::from(timing.space);
        let limits = self.limits(1.0 / (period * 1e-9), scale.abs(), dt);
        self.speed = match self.control {
            Control::Position => self.follow(scale, limits, dt),
            Control::Velocity => self.approach(scale, limits, dt),
        };
        self.frequency.set(self.speed);
        let base = base_ns.unwrap_or(ASSUMED_NS) as f64 * 1e-9;
        let per_speed = STEP as f64 * base;
        let per_accel = per_speed * base;
        self.wanted.ask(whole(self.speed * per_speed), whole(limits.accel * per_accel));
    }

    /// Returns the limits in steps; corrects parameters that exceed the possible rate.
    fn limits(&mut self, most: f64, scale: f64, dt: f64) -> Limits {
        let mut speed = most;
        let maxvel = self.maxvel.get();
        if maxvel > 0.0 {
            let wish = maxvel * scale;
            if wish > most {
                if !self.complained {
                    self.complained = true;
                    self.warn_of_limit(wish, most);
                }
                self.maxvel.set(most / scale);
            } else {
                speed = wish;
            }
        } else if maxvel != 0.0 {
            self.maxvel.set(0.0);
        }
        let mut accel = speed * (1.0 / dt);
        let maxaccel = self.maxaccel.get();
        if maxaccel > 0.0 {
            let wish = maxaccel * scale;
            if wish > accel {
                self.maxaccel.set(accel / scale);
            } else {
                accel = wish;
            }
        } else if maxaccel != 0.0 {
            self.maxaccel.set(0.0);
        }
        Limits { speed, accel }
    }

    fn warn_of_limit(&self, wish: f64, most: f64) {
        self.messages.error(
            "STEPGEN: Channel {}: The requested maximum velocity of {} steps/sec is too high.",
            &[self.number, libm::trunc(wish)],
        );
        self.messages.error(
            "STEPGEN: The maximum possible frequency is {} steps/second",
            &[libm::trunc(most)],
        );
    }

    /// Returns the speed for the next period in velocity mode, in steps per second.
    fn approach(&self, scale: f64, max: Limits, dt: f64) -> f64 {
        let wish = self.command.get() * scale;
        let wish = if wish.is_nan() { 0.0 } else { within(wish, -max.speed, max.speed) };
        let most = max.accel * dt;
        within(wish, self.speed - most, self.speed + most)
    }

    /// Returns the speed for the next period in position mode, in steps per second. It matches the speed of the
    /// command, and accelerates or brakes depending on the positions that either would lead to.
    fn follow(&mut self, scale: f64, max: Limits, dt: f64) -> f64 {
        let per_dt = 1.0 / dt;
        let wish = self.command.get() * scale;
        let goal = if wish.is_finite() { wish } else { self.last_command };
        let goal_speed = (goal - self.last_command) * per_dt;
        self.last_command = goal;
        let (here, speed) = (position(self.made.accum()), self.speed);

        let accel = if goal_speed > speed { max.accel } else { -max.accel };
        let match_time = (goal_speed - speed) / accel;
        let mean = (goal_speed + speed) * 0.5;
        let end = here + mean * match_time;
        let goal_end = goal + goal_speed * (match_time - 1.5 * dt);
        let error = end - goal_end;

        let next = if match_time < dt {
            if error.abs() < 0.0001 {
                goal_speed
            } else {
                let most = max.accel * dt;
                within(goal_speed - 0.5 * error * per_dt, speed - most, speed + most)
            }
        } else {
            let dv = -2.0 * accel * dt;
            let dp = dv * match_time;
            let other = (error + dp * 2.0).abs() < error.abs();
            speed + if other { -accel } else { accel } * dt
        };
        within(next, -max.speed, max.speed)
    }
}

/// Maximum speed in steps per second, and maximum acceleration in steps per second squared.
#[derive(Clone, Copy)]
struct Limits {
    speed: f64,
    accel: f64,
}

/// Scale of a channel, kept away from zero.
#[derive(Clone, Copy)]
pub(crate) struct Scale(pub(crate) ParamRw<f64>);

impl Scale {
    /// Returns the scale in steps per length unit.
    pub(crate) fn get(&self) -> f64 {
        let scale = self.0.get();
        if scale.abs() >= 1e-20 {
            return scale;
        }
        self.0.set(1.0);
        1.0
    }
}

impl Touch for Scale {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
    }
}

/// Returns `x` limited to two bounds.
fn within(x: f64, low: f64, high: f64) -> f64 {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the fraction is dropped, the rest fits")]
const fn whole(x: f64) -> i64 {
    x as i64
}
