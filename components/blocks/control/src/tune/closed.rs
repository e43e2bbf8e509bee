//! Tuning against plants whose ultimate gain and period are known.
//!
//! A relay of ±d makes a loop oscillate with a peak a. By the describing function of a relay, the ultimate gain is
//! 4d/(π·a), and the ultimate period is that of the oscillation. This is exact if the plant passes only the fundamental
//! of the relay's square wave; otherwise the harmonics determine the error.

use crate::pid::Pid;
use core::f64::consts::PI;
use hal_bench::Bench;

const NS: i64 = 1_000_000;
const DT: f64 = 0.001;
const EFFORT: f64 = 0.5;
/// Displacement of the integrators per cycle and unit of output; its product with the effort is exact.
const STEP: f64 = 1.0 / 1024.0;

/// Tunes with `cycles` half cycles on a plant that returns the next feedback for an output. Returns ultimate gain and
/// period.
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
            // The result is published in the next cycle.
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

/// Integrator with a dead time of m cycles. The feedback is a triangle: it crosses 0, continues for m cycles, and comes
/// back, in half cycles of 2m + 1 cycles with peaks of m and m + 1 steps in turn. This equals a dead time L of m + 1/2
/// cycles, for which the peak is d·k·L and the period 4L. The ultimate gain of such a plant, of k per second, is
/// π/(2·k·L); because the triangle is not a sine, the measured gain is 8/π² of that.
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
        // The first half cycle starts from rest: m + 1 cycles, and a peak of one.
        let peak = EFFORT * STEP * (1.0 + (halves - 1.0) * (m + 0.5)) / halves;
        let runs = m + 1.0 + (halves - 1.0) * (2.0 * m + 1.0);
        // Rounding, and the component's value of π.
        close(gain, 4.0 * EFFORT / (PI * peak), 1e-9);
        close(period, 2.0 * runs * DT / halves, 1e-9);
        // Compared with the continuous formulas: within the effect of the first half cycle.
        let (dead, k) = ((m + 0.5) * DT, STEP / DT);
        close(period, 4.0 * dead, 1.0 / halves);
        close(gain, 8.0 / (PI * PI) * PI / (2.0 * k * dead), 1.1 / halves);
    }
}

/// Three first-order lags of one second, 1/(s + 1)³: each has a phase of -60 degrees at √3/s, where their total gain is
/// 1/8. The harmonics k = 3, 5, … pass with 1/k of |G(k·√3)/G(√3)|, in total 0.0215 of the fundamental. That changes
/// the peak by the same fraction, and the phase by as many radians. With a phase slope of 1.3 radians per natural
/// logarithm of frequency, this changes the period by 0.0166; with a gain slope of 2.25 logarithms per logarithm of
/// frequency, it changes the gain by another 0.0373.
#[test]
fn three_lags() {
    let late = libm::sqrt(3.0);
    let level = |k: f64| libm::pow(1.0 + (k * late) * (k * late), -1.5);
    let harmonics: f64 =
        (1..50).map(|n| f64::from(2 * n + 1)).map(|k| level(k) / (k * level(1.0))).sum();
    let period_off = harmonics / (3.0 * late / (1.0 + 3.0));
    let gain_off = harmonics + period_off * 2.25;
    assert!(harmonics < 0.0216 && gain_off < 0.06);
    // Exact state of the plant after a cycle with constant output: powers of T times exp(-T).
    let (hold, halves) = (libm::exp(-DT), 200);
    let [mut a, mut b, mut c] = [0.0; 3];
    let (_, gain, period) = tune(0, halves, |out| {
        let (x, y, z) = (a - out, b - out, c - out);
        a = out + hold * x;
        b = out + hold * (y + DT * x);
        c = out + hold * (z + DT * y + DT * DT / 2.0 * x);
        c
    });
    // The first half cycles start from rest, and each half cycle is resolved to one cycle.
    let begin = 2.0 / f64::from(halves);
    close(gain, 8.0, gain_off + begin);
    close(period, 2.0 * PI / late, period_off + begin);
}

/// Tuning rules for the gains (Ziegler and Nichols).
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
