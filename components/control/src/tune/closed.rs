//! Tuning against plants whose ultimate gain and period are known.
//!
//! A relay of ±d makes a loop oscillate with a peak a. By the describing function of a relay, 4d/(π·a), the ultimate gain is that
//! and the ultimate period that of the oscillation. This is exact where the plant leaves of the relay's square wave only
//! its fundamental; how far it is off otherwise, its harmonics say.

use crate::pid::Pid;
use core::f64::consts::PI;
use hal_component::bench::Bench;

const NS: i64 = 1_000_000;
const DT: f64 = 0.001;
const EFFORT: f64 = 0.5;
/// What the integrators add to their place in a run for each unit of output: times the effort it is exact.
const STEP: f64 = 1.0 / 1024.0;

/// Tunes with `cycles` half cycles on a plant that answers an output with the next feedback: the ultimate gain and period.
fn tune(kind: u32, cycles: u32, mut plant: impl FnMut(f64) -> f64) -> (Bench, f64, f64) {
    let mut bench = Bench::new();
    bench.load::<Pid>(&["names=x", "debug=1"]).unwrap();
    bench.set("x.tune-effort", EFFORT);
    bench.set("x.tune-cycles", cycles);
    bench.set("x.tune-type", kind);
    bench.set("x.tune-mode", true);
    bench.set("x.tune-start", true);
    bench.set("x.enable", true);
    for _ in 0..2_000_000 {
        bench.run("x.do-pid-calcs", NS);
        if !bench.get::<bool>("x.tune-start") {
            // What was found is shown in the next run.
            bench.run("x.do-pid-calcs", NS);
            let (gain, period) = (bench.get("x.ultimate-gain"), bench.get("x.ultimate-period"));
            return (bench, gain, period);
        }
        bench.set("x.feedback", plant(bench.get("x.output")));
    }
    unreachable!("tuning never ends");
}

fn close(is: f64, wanted: f64, part: f64) {
    assert!((is / wanted - 1.0).abs() <= part, "{is} is not {wanted} within {part}");
}

/// An integrator with a dead time of m runs. The feedback is a triangle: it crosses 0, goes on for m runs, and comes back, in
/// half cycles of 2m + 1 runs with peaks of m and m + 1 steps in turn: as with a dead time L of m + 1/2 runs, for which the peak is
/// d·k·L and the period 4L. The ultimate gain of such a plant, of k per second, is π/(2·k·L); that the triangle is no sine leaves
/// 8/π² of it.
#[test]
fn an_integrator_with_dead_time() {
    for m in [4, 20, 100] {
        let mut late = vec![0.0; m];
        let mut y = 0.0;
        let halves = 101;
        let (_, gain, period) = tune(0, halves, |out| {
            late.push(out);
            y += STEP * late.remove(0);
            y
        });
        let (m, halves) = (m as f64, f64::from(halves));
        // The first half cycle is from rest: m + 1 runs, and a peak of one.
        let peak = EFFORT * STEP * (1.0 + (halves - 1.0) * (m + 0.5)) / halves;
        let runs = m + 1.0 + (halves - 1.0) * (2.0 * m + 1.0);
        // Roundings, and the π of the component.
        close(gain, 4.0 * EFFORT / (PI * peak), 1e-9);
        close(period, 2.0 * runs * DT / halves, 1e-9);
        // Seen from afar: within a half cycle of the first one.
        let (dead, k) = ((m + 0.5) * DT, STEP / DT);
        close(period, 4.0 * dead, 1.0 / halves);
        close(gain, 8.0 / (PI * PI) * PI / (2.0 * k * dead), 1.1 / halves);
    }
}

/// Three lags of a second, 1/(s + 1)³: each a quarter of a turn's third late at √3/s, where 8 times its gain is 1. The harmonics k = 3, 5, …
/// come through with 1/k of |G(k·√3)/G(√3)|, in all 0.0215 of the fundamental. That moves the peak by as much, and the phase by as many
/// radians; which, with 1.3 radians of phase to a natural logarithm of frequency, moves the period by 0.0166, and with 2.25
/// logarithms of gain to one of frequency, the gain by 0.0373 more.
#[test]
fn three_lags() {
    let late = libm::sqrt(3.0);
    let level = |k: f64| libm::pow(1.0 + (k * late) * (k * late), -1.5);
    let harmonics: f64 =
        (1..50).map(|n| f64::from(2 * n + 1)).map(|k| level(k) / (k * level(1.0))).sum();
    let period_off = harmonics / (3.0 * late / (1.0 + 3.0));
    let gain_off = harmonics + period_off * 2.25;
    assert!(harmonics < 0.0216 && gain_off < 0.06);
    // What the plant is after a run with a constant output, exactly: the powers of T in front of exp(-T).
    let (hold, halves) = (libm::exp(-DT), 200);
    let [mut a, mut b, mut c] = [0.0; 3];
    let (_, gain, period) = tune(0, halves, |out| {
        let (x, y, z) = (a - out, b - out, c - out);
        a = out + hold * x;
        b = out + hold * (y + DT * x);
        c = out + hold * (z + DT * y + DT * DT / 2.0 * x);
        c
    });
    // The first half cycles are from rest; of each half cycle up to a run is missed.
    let begin = 2.0 / f64::from(halves);
    close(gain, 8.0, gain_off + begin);
    close(period, 2.0 * PI / late, period_off + begin);
}

/// The rules by which gains follow (Ziegler and Nichols's).
#[test]
fn gains_by_the_rules() {
    for kind in [0, 1] {
        let (mut late, mut y) = ([0.0; 5], 0.0);
        let (bench, gain, period) = tune(kind, 20, |out| {
            late.rotate_left(1);
            y += STEP * core::mem::replace(&mut late[4], out);
            y
        });
        let get = |name: &str| bench.get::<f64>(&format!("x.{name}"));
        let rule = if kind == 0 {
            [0.6 * gain, 1.2 * gain / period, 0.6 * gain * period / 8.0, 0.0]
        } else {
            [0.45 * gain, 0.54 * gain / period, 0.0, 1.0]
        };
        for (name, wanted) in ["Pgain", "Igain", "Dgain", "FF1"].iter().zip(rule) {
            let is = get(name);
            assert!(
                (is - wanted).abs() <= 2.0 * f64::EPSILON * wanted,
                "{kind} {name}: {is}, not {wanted}"
            );
        }
    }
}
