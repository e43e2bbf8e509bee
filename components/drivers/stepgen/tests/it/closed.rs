//! Test of `stepgen` against its parameters: distances, rates, and timing of pulses and direction changes.

use hal_bench::Random;
use rig::Rig;

use crate::rig;

/// Base period and servo period, in seconds.
const BASE: f64 = 1e-4;
const SERVO: f64 = 1e-3;
/// Resolution of a position, in steps.
const GRAIN: f64 = 1.0 / 268_435_456.0;

/// Acceleration from rest to a speed v takes v²/2a of distance. In discrete time the rate grows once per base period,
/// which adds half a base period at v to the distance; the rate itself is truncated to a whole number of grains per
/// period.
#[test]
fn speeding_up_takes_v_squared_over_2a() {
    for (scale, v, a) in [(100.0, 20.0, 200.0), (4.0, 90.0, 1500.0), (-250.0, 10.0, 35.0)] {
        let mut rig = Rig::new(&["step_type=2"]);
        rig.float("0.position-scale", scale);
        rig.float("0.maxvel", v);
        rig.float("0.maxaccel", a);
        rig.enable(0, true);
        rig.run(1);
        rig.float("0.position-cmd", 1000.0);
        let mut n = 0;
        while rig.get::<f64>("0.frequency").abs() < v * f64::abs(scale) * (1.0 - 1e-12) {
            rig.run(10);
            n += 1;
        }
        // v/a in whole servo periods; the last one may have less to add, and still has to be carried out.
        assert!((f64::from(n) - v / (a * SERVO)).abs() <= 1.0 + 1e-9, "{n} periods to {v} at {a}");
        rig.run(10);
        let began = rig.get::<f64>("0.position-fb");
        rig.run(1000);
        let even = rig.get::<f64>("0.position-fb") - began;
        let cut = 1000.0 * GRAIN / scale.abs();
        assert!(even <= v * 0.1 + 1e-9 && v * 0.1 - even <= cut + 1e-9, "{even} in 0.1 s at {v}");
        // At full speed from the start, it would be ahead by v²/2a, except for the order of the functions: up to one
        // servo period until a command is seen, one until the rate is carried out, and half a base period as above.
        let ran = f64::from(n + 1) * SERVO;
        let lost = v * ran - began;
        let wanted = v * v / (2.0 * a);
        assert!((lost - wanted).abs() <= v * 2.0 * SERVO, "{v} at {a}: {lost} lost, not {wanted}");
    }
}

/// A rate of f steps per second makes ⌊x + n·r⌋ steps in n base periods, from a position x halfway between two steps,
/// where r is f·T in whole grains: over a long run, at most n grains fewer than f·T·n.
#[test]
fn rates_are_exact_over_a_long_run() {
    for f in [1.0, 333.25, 1234.567, -4999.9] {
        let mut rig = Rig::new(&["step_type=2", "ctrl_type=v"]);
        rig.enable(0, true);
        rig.float("0.velocity-cmd", f);
        // Runs until the rate is reached, and until a capture.
        rig.run(101);
        let x = rig.get::<f64>("0.position-fb") + 0.5;
        let periods = 300_000;
        rig.run(periods);
        let n = periods as f64;
        let per_period = libm::trunc(f * BASE / GRAIN) * GRAIN;
        let wanted = libm::floor(x + n * per_period);
        assert_eq!(f64::from(rig.get::<i32>("0.rawcounts")), wanted, "{f} Hz");
        assert!((wanted - x - f * BASE * n).abs() <= 1.0 + n * GRAIN, "{f} Hz");
    }
}

/// In velocity mode the distance is the integral of the speed: trapezoids during acceleration, exact to the grain.
#[test]
fn speed_mode_integrates_its_command() {
    let (scale, a) = (1000.0, 50.0);
    let mut rig = Rig::new(&["step_type=2", "ctrl_type=v"]);
    rig.float("0.position-scale", scale);
    rig.float("0.maxaccel", a);
    rig.enable(0, true);
    rig.run(1);
    let (mut speed, mut area, mut servos) = (0.0, 0.0, 0);
    // Each change, and each rest, is a whole number of servo periods.
    for (to, periods) in [(2.0, 200), (-1.5, 300), (4.0, 150), (0.0, 400)] {
        rig.float("0.velocity-cmd", to);
        rig.run(10 * periods);
        let ramp = f64::abs(to - speed) / a;
        let length = periods as f64 * SERVO;
        area += (speed + to) / 2.0 * ramp + to * (length - ramp);
        speed = to;
        servos += periods;
    }
    // At rest, no steps are pending.
    rig.run(20);
    // Each of three changes costs half a base period; each period truncates up to a grain of rate and one of ramp.
    let steps = 2.0 * (2.0 + 3.5 + 5.5 + 4.0) * BASE / 2.0 * scale;
    let cut = servos as f64 * 10.0 * GRAIN * (1.0 + 10.0);
    let is = rig.get::<f64>("0.position-fb");
    assert!((is - area).abs() <= (steps + cut) / scale, "{is}, not {area}");
}

/// Within a servo period, the rate also grows by a·T² steps in each base period T, before it is added: N base periods
/// from rest give a·T²·N(N + 1)/2. Here a·T² is a whole number of grains, of which the conversions may lose one.
#[test]
fn a_ramp_grows_in_every_base_period() {
    let grains = 131_072.0;
    let a = grains * GRAIN / (BASE * BASE);
    let mut rig = Rig::new(&["step_type=2", "ctrl_type=v"]);
    rig.float("0.maxaccel", a);
    rig.enable(0, true);
    rig.run(20);
    rig.float("0.velocity-cmd", 4000.0);
    // The command is seen at the end of a servo period.
    rig.run(10);
    let began = rig.get::<f64>("0.position-fb");
    for servos in 1..=60 {
        rig.run(10);
        let n = f64::from(10 * servos);
        let gone = rig.get::<f64>("0.position-fb") - began;
        let wanted = grains * GRAIN * n * (n + 1.0) / 2.0;
        assert!((gone - wanted).abs() <= n * n * GRAIN, "{servos}: {gone}, not {wanted}");
    }
}

/// A move of a whole number of steps makes as many pulses, each as long as `steplen` and at least `stepspace` apart; at
/// the maximum rate, both are exact.
#[test]
fn pulses_are_counted_and_timed() {
    for (len, space) in [(1, 1), (100_000, 300_000), (250_000, 100_000), (150_000, 150_000)] {
        let whole = |ns: u32| ns.div_ceil(100_000) as usize;
        for steps in [1_i32, 7, 500, -321] {
            let mut rig = Rig::new(&["step_type=0"]);
            rig.ns("0.steplen", len);
            rig.ns("0.stepspace", space);
            rig.float("0.maxaccel", 20_000.0);
            rig.enable(0, true);
            rig.run(1);
            rig.float("0.position-cmd", f64::from(steps));
            let line = rig.trace("0.step", 20_000);
            let pulses: Vec<&str> = line.split('.').filter(|p| !p.is_empty()).collect();
            assert_eq!(pulses.len(), steps.unsigned_abs() as usize, "{len} {space} {steps}");
            assert!(pulses.iter().all(|p| p.len() == whole(len)), "{len} {space} {steps}");
            let gaps = line.trim_matches('.').split('#').map(str::len).filter(|n| *n > 0);
            assert!(gaps.min().is_none_or(|gap| gap >= whole(space)), "{len} {space} {steps}");
            assert_eq!(rig.get::<i32>("0.rawcounts"), steps);
        }
        let mut rig = Rig::new(&["step_type=0", "ctrl_type=v"]);
        rig.ns("0.steplen", len);
        rig.ns("0.stepspace", space);
        rig.enable(0, true);
        rig.float("0.velocity-cmd", 1e9);
        rig.run(50);
        let period = whole(len) + whole(space);
        let most = 1e9 / (period as f64 * 1e5);
        assert_eq!(rig.get::<f64>("0.frequency"), most, "{len} {space}");
        let line = rig.trace("0.step", period * 100);
        assert_eq!(line.matches(".#").count() + usize::from(line.starts_with('#')), 100);
    }
}

/// For any command, a pulse has its set length, and `dir` is held for `dirhold` after it and set `dirsetup` before the
/// next. (If the last pulse is longer ago than all of that, the channel was at rest, and its first step may come at any
/// time.)
#[test]
fn directions_hold_and_are_there_in_time() {
    let (mut random, mut turns) = (Random::new(9), 0);
    for _ in 0..20 {
        let times = [0; 4].map(|_| random.pick(&[1, 100_000, 150_000, 400_000, 1_000_000]));
        let [len, space, hold, setup] = times;
        let mut rig = Rig::new(&["step_type=0", "ctrl_type=v"]);
        for (name, ns) in ["steplen", "stepspace", "dirhold", "dirsetup"].iter().zip(times) {
            rig.ns(&format!("0.{name}"), ns);
        }
        rig.enable(0, true);
        let whole = |ns: u32| i64::from(ns.div_ceil(100_000));
        let mut was = (false, false);
        let (mut rose, mut fell, mut turned) = (None::<i64>, None::<i64>, None::<i64>);
        for now in 0..8000 {
            if now % 200 == 0 {
                let most = 1e9 / f64::from(len + space);
                rig.float("0.velocity-cmd", random.between(-most, most));
            }
            rig.tick();
            let is = (rig.get::<bool>("0.step"), rig.get::<bool>("0.dir"));
            let since = |then: Option<i64>| then.map(|then| now - then);
            if is.1 != was.1 {
                assert!(!was.0 || !is.0, "{times:?}: dir changes in a pulse, {now}");
                assert!(since(fell).is_none_or(|n| n >= whole(hold)), "{times:?}: hold, {now}");
                let all = whole(len) + whole(hold) + whole(setup);
                turned = since(rose).filter(|n| *n < all).map(|_| now);
                turns += usize::from(turned.is_some());
            }
            if is.0 && !was.0 {
                assert!(since(turned).is_none_or(|n| n >= whole(setup)), "{times:?}: setup, {now}");
                rose = Some(now);
            }
            if !is.0 && was.0 {
                assert_eq!(since(rose).unwrap(), whole(len), "{times:?}: length, {now}");
                fell = Some(now);
            }
            was = is;
        }
    }
    assert!(turns >= 50, "{turns} turns in all");
}
