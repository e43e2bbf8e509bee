//! Realtime. `stepper`.

use crate::motion::{Event, Ramp, SPAN_NS, Speed};
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Time without a step after which the motor counts as at rest, in nanoseconds.
const REST_NS: i64 = 100_000_000;

/// Simulated stepper motor with its load, which follows step and direction as long as it can.
///
/// Steps that come too fast, or that accelerate or brake too hard, stall the motor: it then loses every step until none
/// has come for 20 ms. Speed is the mean over 20 ms; acceleration is fitted to the steps of a ramp, which needs eight
/// steps over 30 ms. Add the function after the one that makes the steps, in the same thread.
///
/// # Example
///
/// ```hal
/// loadrt stepgen step_type=0
/// loadrt stepper
/// loadrt threads name1=base period1=50000 name2=servo period2=1000000
/// addf stepgen.make-pulses base
/// addf stepper.0 base
/// addf stepgen.update-freq servo
/// net step stepgen.0.step stepper.0.step
/// net dir stepgen.0.dir stepper.0.dir
/// start
/// setp stepgen.0.position-scale 100
/// setp stepper.0.scale 100
/// setp stepper.0.max-accel 10
/// setp stepgen.0.maxvel 5
/// setp stepgen.0.maxaccel 5
/// setp stepgen.0.enable 1
/// setp stepgen.0.position-cmd 2
/// run 3s
/// getp stepper.0.counts # -> 200
/// getp stepper.0.lost # -> 0
/// # Four times as hard, it loses steps.
/// setp stepgen.0.maxaccel 40
/// setp stepgen.0.position-cmd 0
/// run 3s
/// getp stepper.0.counts # -> 0
/// ```
#[derive(Component)]
#[hal(fast)]
pub struct Stepper {
    /// Step input: one step at each rising edge.
    step: In<bool>,
    /// Direction of the steps: FALSE forward, TRUE backward.
    dir: In<bool>,
    /// Commanded position in steps, which the motor would have without lost steps; it wraps.
    counts: Out<i32>,
    /// Position of the shaft, in length units.
    position: Out<f64>,
    /// Number of lost steps so far, in either direction; it wraps.
    lost: Out<i32>,
    /// Commanded speed, in length units per second: the mean over 20 ms, updated at each step; 0 after 100 ms without a
    /// step.
    speed: Out<f64>,
    /// Commanded acceleration, in length units per second squared: fitted to the present ramp; 0 while the ramp is too
    /// short.
    accel: Out<f64>,
    /// True while the motor loses steps.
    stalled: Out<bool>,
    /// Steps per length unit; 0 or NaN counts as 1.
    #[hal(default = 1.0)]
    scale: ParamRw<f64>,
    /// Speed above which the motor stalls, in length units per second; 0: no limit.
    max_vel: ParamRw<f64>,
    /// Acceleration above which the motor stalls, in length units per second squared; 0: no limit.
    max_accel: ParamRw<f64>,
    #[state]
    now_ns: i64,
    #[state]
    last_ns: i64,
    #[state]
    was_high: bool,
    #[state]
    moving: bool,
    #[state]
    stall: bool,
    #[state]
    commanded: i64,
    #[state]
    shaft: i64,
    #[state]
    missed: i32,
    #[state]
    #[hal(default = Speed::new())]
    mean: Speed,
    #[state]
    ramp: Ramp,
}

impl Update for Stepper {
    fn update(&mut self, period: Period) {
        self.now_ns = self.now_ns.wrapping_add(period.ns());
        let high = self.step.get();
        let edge = high && !self.was_high;
        self.was_high = high;
        if edge {
            self.turn(if self.dir.get() { -1 } else { 1 });
        } else if self.moving {
            self.rest(self.now_ns.wrapping_sub(self.last_ns));
        }
        self.counts.set(low(self.commanded));
        self.lost.set(self.missed);
        self.stalled.set(self.stall);
        self.position.set(self.shaft as f64 / self.scale());
    }
}

impl Stepper {
    fn turn(&mut self, by: i64) {
        let now = Event { ns: self.now_ns, at: self.commanded as f64 + 0.5 * by as f64 };
        self.commanded = self.commanded.wrapping_add(by);
        self.last_ns = self.now_ns;
        self.moving = true;
        let scale = self.scale();
        let speed = self.mean.step(now) / scale;
        let accel = self.ramp.step(now).unwrap_or(0.0) / scale;
        self.speed.set(speed);
        self.accel.set(accel);
        let beyond = |x: f64, limit: f64| limit > 0.0 && x.abs() > limit;
        if beyond(speed, self.max_vel.get()) || beyond(accel, self.max_accel.get()) {
            self.stall = true;
        }
        if self.stall {
            self.missed = self.missed.wrapping_add(1);
        } else {
            self.shaft = self.shaft.wrapping_add(by);
        }
    }

    fn rest(&mut self, idle_ns: i64) {
        if idle_ns >= SPAN_NS {
            self.stall = false;
        }
        if idle_ns >= REST_NS {
            self.moving = false;
            self.mean.clear();
            self.ramp.clear();
            self.speed.set(0.0);
            self.accel.set(0.0);
        }
    }

    fn scale(&self) -> f64 {
        let scale = self.scale.get();
        if scale.is_nan() || scale == 0.0 { 1.0 } else { scale }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "counts wrap")]
const fn low(count: i64) -> i32 {
    count as i32
}
