//! Tests of `stepper`.

#![expect(clippy::unwrap_used, reason = "tests")]

use hal_bench::Bench;
use stepper::Stepper;

const TICK_NS: i64 = 100_000;

/// Motor with 100 steps per unit, fed step by step.
struct Rig {
    bench: Bench,
    /// Commanded position, including the fraction of a step.
    at: f64,
    count: i32,
}

impl Rig {
    fn new(max_vel: f64, max_accel: f64) -> Self {
        let mut bench = Bench::new();
        bench.load::<Stepper>(&[]).unwrap();
        bench.set("stepper.0.scale", 100.0);
        bench.set("stepper.0.max-vel", max_vel);
        bench.set("stepper.0.max-accel", max_accel);
        Self { bench, at: 0.0, count: 0 }
    }

    fn get<T: hal_component::Value>(&self, name: &str) -> T {
        self.bench.get(&format!("stepper.0.{name}"))
    }

    fn tick(&self, step: bool, dir: bool) {
        self.bench.set("stepper.0.step", step);
        self.bench.set("stepper.0.dir", dir);
        self.bench.run("stepper.0", TICK_NS);
    }

    /// Moves at constant acceleration from a speed, for some milliseconds. Returns the speed at the end.
    fn ramp(&mut self, mut speed: f64, accel: f64, ms: u32) -> f64 {
        let dt = 1e-4;
        for _ in 0..ms * 10 {
            self.at += 100.0 * (speed + 0.5 * accel * dt) * dt;
            speed += accel * dt;
            let count = libm::round(self.at);
            let due = count - f64::from(self.count);
            assert!(due.abs() <= 1.0, "more than a step per period");
            if due == 0.0 {
                self.tick(false, speed < 0.0);
            } else {
                self.tick(true, due < 0.0);
                self.count += if due < 0.0 { -1 } else { 1 };
            }
        }
        speed
    }
}

#[test]
fn rising_edges_count() {
    let rig = Rig::new(0.0, 0.0);
    for (step, dir, count) in [
        (false, false, 0),
        (true, false, 1),
        (true, false, 1),
        (true, true, 1),
        (false, true, 1),
        (true, true, 0),
        (false, true, 0),
        (true, true, -1),
    ] {
        rig.tick(step, dir);
        assert_eq!(rig.get::<i32>("counts"), count);
        assert_eq!(rig.get::<f64>("position"), f64::from(count) / 100.0);
    }
    assert_eq!((rig.get::<i32>("lost"), rig.get::<bool>("stalled")), (0, false));
}

#[test]
fn speed_is_the_mean_of_20_ms() {
    let mut rig = Rig::new(0.0, 0.0);
    // 3428 steps per second appear as intervals of 200 and 300 µs.
    rig.ramp(34.28, 0.0, 50);
    for _ in 0..200 {
        rig.ramp(34.28, 0.0, 1);
        let speed: f64 = rig.get("speed");
        assert!((speed - 34.28).abs() < 0.2, "{speed}");
    }
    rig.ramp(-0.3, 0.0, 400);
    let speed: f64 = rig.get("speed");
    assert!((speed + 0.3).abs() < 0.002, "{speed}");
    rig.ramp(0.0, 0.0, 99);
    assert_eq!((rig.get::<f64>("speed"), rig.get::<f64>("accel")), (0.0, 0.0));
}

#[test]
fn acceleration_is_that_of_the_ramp() {
    for accel in [40.0, 400.0, -90.0] {
        let mut rig = Rig::new(0.0, 0.0);
        let ms = if accel > 100.0 { 80 } else { 300 };
        rig.ramp(0.0, accel, ms);
        let seen: f64 = rig.get("accel");
        assert!((seen / accel - 1.0).abs() < 0.01, "{seen} instead of {accel}");
        let top = accel * f64::from(ms) * 1e-3;
        rig.ramp(top, 0.0, 200);
        assert_eq!(rig.get::<f64>("accel"), 0.0, "no ramp");
        rig.ramp(top, -accel, ms - 10);
        let seen: f64 = rig.get("accel");
        assert!((seen / accel + 1.0).abs() < 0.05, "{seen} instead of {}", -accel);
    }
}

/// Limits of the motor, the motion requested, and whether the motor can follow.
#[test]
fn stalls_beyond_its_limits_only() {
    for (max_vel, max_accel, accel, ms, holds) in [
        (13.5, 42.5, 40.0, 300, true),
        (13.5, 42.5, 40.0, 375, false),
        (13.5, 42.5, 45.0, 266, false),
        (0.0, 42.5, 40.0, 750, true),
        (13.5, 0.0, 400.0, 30, true),
        (0.0, 0.0, 900.0, 50, true),
        (f64::NAN, -1.0, 900.0, 50, true),
    ] {
        let top = accel * f64::from(ms) * 1e-3;
        for way in [1.0, -1.0] {
            let mut rig = Rig::new(max_vel, max_accel);
            rig.ramp(0.0, way * accel, ms);
            rig.ramp(way * top, 0.0, 100);
            assert_eq!(rig.get::<bool>("stalled"), !holds, "{top} {accel}");
            rig.ramp(way * top, -way * accel, ms);
            assert_eq!(rig.get::<i32>("lost") == 0, holds, "{top} {accel}");
            assert_eq!(rig.get::<i32>("counts"), rig.count);
            let shaft = f64::from(rig.count) / 100.0 == rig.get::<f64>("position");
            assert_eq!(shaft, holds, "{top} {accel}");
        }
    }
}

#[test]
fn a_stalled_motor_takes_hold_again_at_rest() {
    let mut rig = Rig::new(5.0, 0.0);
    rig.ramp(10.0, 0.0, 50);
    let (lost, at): (i32, f64) = (rig.get("lost"), rig.get("position"));
    assert!(lost > 10 && rig.get::<bool>("stalled"), "{lost}");
    rig.ramp(0.0, 0.0, 21);
    assert!(!rig.get::<bool>("stalled"));
    rig.ramp(-2.0, 0.0, 500);
    assert_eq!(rig.get::<i32>("lost"), lost, "slow enough");
    let moved = rig.get::<f64>("position") - at;
    assert!((moved + 1.0).abs() < 0.011, "{moved}");
}

#[test]
fn a_scale_of_nothing_counts_as_one() {
    for (scale, unit) in [(0.0, 1.0), (f64::NAN, 1.0), (-4.0, -0.25)] {
        let rig = Rig::new(0.0, 0.0);
        rig.bench.set("stepper.0.scale", scale);
        rig.tick(true, false);
        assert_eq!(rig.get::<f64>("position"), unit, "{scale}");
    }
}
