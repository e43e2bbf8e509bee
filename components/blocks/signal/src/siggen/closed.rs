//! Test of `siggen` against its waveforms as functions of time: after n cycles of T seconds, the position within the
//! wave is the fraction of n·f·T, and determines every output. Here f·T is k/N, so that all positions are known
//! exactly.

use super::{PI, Siggen};
use core::f64::consts::TAU;
use hal_bench::{Bench, Random};

const NS: i64 = 1_000_000;
const DT: f64 = 0.001;

/// Largest difference of the sines due to the component's π.
const OFF: f64 = 2.0 * (PI - core::f64::consts::PI);

struct Rig {
    bench: Bench,
    amplitude: f64,
    offset: f64,
}

impl Rig {
    fn new(frequency: f64, amplitude: f64, offset: f64) -> Self {
        let mut bench = Bench::new();
        bench.load::<Siggen>(&["names=x"]).unwrap();
        for (pin, value) in [("frequency", frequency), ("amplitude", amplitude), ("offset", offset)]
        {
            bench.set(&format!("x.{pin}"), value);
        }
        Self { bench, amplitude, offset }
    }

    fn run(&self) {
        self.bench.run("x.update", NS);
    }

    /// Returns an output, normalized to amplitude 1 around 0.
    fn unit(&self, pin: &str) -> f64 {
        let is: f64 = self.bench.get(&format!("x.{pin}"));
        (is - self.offset) / self.amplitude
    }

    /// Returns a bound of the rounding in the output and here.
    fn rounding(&self) -> f64 {
        8.0 * f64::EPSILON * (1.0 + self.offset.abs() / self.amplitude)
    }
}

/// By position within the wave, half a cycle later: the square is low, then high; the sawtooth rises; the triangle
/// falls and then rises.
#[test]
fn every_wave_follows_from_the_place() {
    let mut random = Random::new(1);
    for _ in 0..50 {
        // With an odd number of positions, none is in the middle.
        let places = 2 * random.below(200) + 3;
        let k = 1 + random.below(places / 2);
        let frequency = k as f64 / places as f64 / DT;
        let rig = Rig::new(frequency, random.scaled(0.1, 100.0), random.between(-50.0, 50.0));
        for n in 1..=2000_u64 {
            rig.run();
            let at = (n * k % places) as f64 / places as f64;
            // Each cycle rounds the position and the step.
            let bound = 2.0 * n as f64 * f64::EPSILON + rig.rounding();
            let off = |pin: &str, wanted: f64, slope: f64| {
                let is = rig.unit(pin);
                let why = format!("{pin} at {at} in run {n}: {is}, not {wanted}");
                assert!((is - wanted).abs() <= slope * bound, "{why}");
            };
            off("triangle", 4.0 * (at - 0.5).abs() - 1.0, 4.0);
            let sines = TAU + OFF / bound;
            off("sine", libm::sin(TAU * at), sines);
            off("cosine", libm::cos(TAU * at), sines);
            // At the end of a wave the outputs jump, a rounding earlier or later.
            if !(n * k).is_multiple_of(places) {
                off("sawtooth", 2.0 * at - 1.0, 2.0);
                off("square", if at > 0.5 { 1.0 } else { -1.0 }, 1.0);
                assert_eq!(rig.bench.get::<bool>("x.clock"), at > 0.5);
            }
        }
    }
}

/// Over a wave of N positions, from any start: Σ saw² is N/3 + 2/(3N), Σ sin² = Σ cos² = N/2.
#[test]
fn powers_of_the_waves() {
    for places in [4_u32, 10, 64, 250] {
        let rig = Rig::new(1.0 / f64::from(places) / DT, 1.0, 0.0);
        let n = f64::from(places);
        (0..7).for_each(|_| rig.run());
        let (mut saw, mut sine, mut cosine, mut across) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..places {
            rig.run();
            let (s, c) = (rig.unit("sine"), rig.unit("cosine"));
            saw += rig.unit("sawtooth") * rig.unit("sawtooth");
            sine += s * s;
            cosine += c * c;
            across += s * c;
        }
        let bound = n * (OFF * 2.0 + 1e-12);
        for (is, wanted) in [(sine, n / 2.0), (cosine, n / 2.0), (across, 0.0)] {
            assert!((is - wanted).abs() <= bound, "{places}: {is}, not {wanted}");
        }
        // A position that is 1 less a rounding counts as the last instead of the first: both have the same square.
        let wanted = n / 3.0 + 2.0 / (3.0 * n);
        assert!((saw - wanted).abs() <= 1e-9, "{places}: {saw}, not {wanted}");
    }
}

/// No wave can be faster than half of the thread's frequency (Nyquist): above that, there are two positions per wave,
/// and the frequency pin is corrected.
#[test]
fn half_of_the_threads_frequency_is_the_highest() {
    for asked in [500.0, 500.1, 1e6, f64::INFINITY] {
        let rig = Rig::new(asked, 1.0, 0.0);
        rig.run();
        for n in 2..50 {
            rig.run();
            assert!(!rig.bench.get::<bool>("x.clock"), "{asked}, {n}");
            let at = if n % 2 == 0 { -1.0 } else { 0.0 };
            assert!((rig.unit("sawtooth") - at).abs() < 1e-12, "{asked}, {n}");
        }
        let is: f64 = rig.bench.get("x.frequency");
        assert!((is - 500.0).abs() < 1e-9, "{asked}: {is}");
    }
}

/// A reset sets the middle of the wave, from which it continues.
#[test]
fn a_reset_is_half_a_cycle() {
    let rig = Rig::new(10.0, 1.0, 0.0);
    (0..33).for_each(|_| rig.run());
    rig.bench.set("x.reset", true);
    for _ in 0..3 {
        rig.run();
        assert_eq!(rig.unit("sawtooth"), 0.0);
        assert_eq!(rig.unit("triangle"), -1.0);
    }
    rig.bench.set("x.reset", false);
    for n in 1..50 {
        rig.run();
        assert!((rig.unit("sawtooth") - 0.02 * f64::from(n)).abs() < 1e-12, "{n}");
        assert_eq!(rig.unit("square"), 1.0);
    }
}
