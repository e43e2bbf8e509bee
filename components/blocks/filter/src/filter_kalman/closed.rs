//! Test of `filter_kalman` against the closed forms for a random walk that is measured: x changes with a variance Q per
//! cycle, and a measurement z has the variance R (Kalman, 1960; Anderson and Moore, "Optimal Filtering", 4.4).
//!
//! Without change it is the Bayes estimate of a constant: after n measurements Σz/(n + R), because the prior is 0 with
//! the variance 1. With change the gain is K = p/R, where p is the posterior variance, which follows a Möbius map: with
//! its fixed points s and t, each cycle multiplies (p - s)/(p - t) by (1 - k)², where k = s/R is the steady-state gain.
//! State between cycles is rounded to single precision.

use super::FilterKalman;
use hal_bench::{Bench, Random};

/// Rounding error of the state, relative.
const ROUND: f64 = 1.0 / (1 << 24) as f64;

struct Rig(Bench);

impl Rig {
    fn new(change: f64, noise: f64) -> Self {
        let mut bench = Bench::new();
        bench.load::<FilterKalman>(&[]).unwrap();
        bench.set("filter-kalman.0.Qk", change);
        bench.set("filter-kalman.0.Rk", noise);
        Self(bench)
    }

    fn measure(&self, z: f64) -> f64 {
        self.0.set("filter-kalman.0.zk", z);
        self.0.run("filter-kalman.0", 1_000_000);
        self.0.get("filter-kalman.0.xk-out")
    }
}

/// Theory for an initial variance of 1.
struct Theory {
    noise: f64,
    /// Fixed points of the map.
    s: f64,
    t: f64,
}

impl Theory {
    fn new(change: f64, noise: f64) -> Self {
        let root = libm::sqrt(change * change + 4.0 * change * noise);
        Self { noise, s: (root - change) / 2.0, t: (-root - change) / 2.0 }
    }

    fn at_rest(&self) -> f64 {
        self.s / self.noise
    }

    /// Returns the gain of measurement number n, from 1.
    fn gain(&self, n: i32) -> f64 {
        let (s, t) = (self.s, self.t);
        let keeps = 1.0 - self.at_rest();
        let ratio = (1.0 - s) / (1.0 - t) * libm::pow(keeps, 2.0 * f64::from(n));
        (s - t * ratio) / (1.0 - ratio) / self.noise
    }
}

/// Each of n cycles rounds the estimate and the variance, of which the gain is a fraction: Σ n·K is less than n.
#[test]
fn what_does_not_change_is_averaged() {
    let mut random = Random::new(1);
    for _ in 0..100 {
        let noise = random.scaled(0.01, 100.0);
        let rig = Rig::new(0.0, noise);
        let (mut sum, mut largest) = (0.0, 0.0);
        for n in 1..=200 {
            let z = random.between(-5.0, 20.0);
            sum += z;
            largest = f64::max(largest, z.abs());
            let (is, n) = (rig.measure(z), f64::from(n));
            let wanted = sum / (n + noise);
            let bound = 3.0 * n * ROUND * largest;
            assert!((is - wanted).abs() <= bound, "{noise}, {n}: {is}, not {wanted}");
        }
    }
}

/// A measurement with a deviation of 1 from the estimate moves it by the gain.
#[test]
fn the_gain_goes_as_its_moebius_map() {
    let mut random = Random::new(2);
    for _ in 0..200 {
        let (change, noise) = (random.scaled(1e-4, 10.0), random.scaled(0.01, 100.0));
        let (rig, theory) = (Rig::new(change, noise), Theory::new(change, noise));
        let least = theory.at_rest().min(theory.gain(1));
        let mut x: f64 = 0.0;
        for n in 1..=60 {
            let side = if n % 2 == 0 { 1.0 } else { -1.0 };
            let now = rig.measure(x + side);
            let (is, wanted) = ((now - x) * side, theory.gain(n));
            // The estimate and the variance are rounded; the variance's roundings decay by 1 - K at least.
            let bound = ROUND * (1.0 + 2.0 * x.abs() + wanted / least) + 1e-12;
            assert!((is - wanted).abs() <= bound, "{change} {noise} {n}: {is}, not {wanted}");
            x = now;
        }
    }
}

/// In steady state it is a first-order low-pass filter: the step response is 1 - (1 - k)ⁿ.
#[test]
fn a_step_at_rest() {
    let mut random = Random::new(3);
    for _ in 0..100 {
        let (change, noise) = (random.scaled(0.01, 10.0), random.scaled(0.01, 10.0));
        let (rig, theory) = (Rig::new(change, noise), Theory::new(change, noise));
        let k = theory.at_rest();
        for _ in 0..2000 {
            assert_eq!(rig.measure(0.0), 0.0);
        }
        for n in 1..=100 {
            let (is, wanted) = (rig.measure(1.0), 1.0 - libm::pow(1.0 - k, f64::from(n)));
            assert!(
                (is - wanted).abs() <= 2.0 * ROUND / k,
                "{change} {noise} {n}: {is}, not {wanted}"
            );
        }
    }
}

/// A ramp is followed with the lag of a low-pass filter, slope·(1 - k)/k.
#[test]
fn a_ramp_at_rest() {
    let (change, noise) = (2.0, 4.0);
    let rig = Rig::new(change, noise);
    let k = Theory::new(change, noise).at_rest();
    assert_eq!(k, 0.5);
    for n in 1..=500 {
        let z = 0.25 * f64::from(n);
        let lag = z - rig.measure(z);
        if n > 100 {
            let wanted = 0.25 * (1.0 - k) / k;
            assert!((lag - wanted).abs() <= 4.0 * ROUND * z / k, "{n}: {lag}, not {wanted}");
        }
    }
}
