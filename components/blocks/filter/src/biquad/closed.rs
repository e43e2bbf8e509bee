//! Test of `biquad` against its transfer function, H(z) = (n0 + n1/z + n2/z²) / (1 + d1/z + d2/z²): on the unit circle
//! it is the response to sines, and its partial fractions give the step response. The designs are those of the Audio EQ
//! Cookbook: the bilinear transforms of 1/(s² + s/Q + 1) and (s² + 1)/(s² + s/Q + 1), prewarped at f0.

#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "how many runs")]

use super::Biquad;
use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI, TAU};
use hal_bench::{Bench, response};
use nalgebra::Complex;

const NS: i64 = 1_000_000;
const DT: f64 = 0.001;
/// Number of samples of a measurement: sines of k Hz are exact.
const SAMPLES: u32 = 1000;
/// Relative error of the component's π.
const OFF: f64 = 3e-13;

const LOW_PASS: u32 = 1;
const NOTCH: u32 = 2;

/// Coefficients that the component was set to, or computed.
#[derive(Clone, Copy, Debug)]
struct Coefficients {
    n: [f64; 3],
    d: [f64; 2],
}

impl Coefficients {
    /// Returns H at the angle `w` on the unit circle.
    fn at(&self, w: f64) -> Complex<f64> {
        self.of(Complex::from_polar(1.0, -w))
    }

    /// Returns H, where `back` is 1/z.
    fn of(&self, back: Complex<f64>) -> Complex<f64> {
        let [n0, n1, n2] = self.n;
        let [d1, d2] = self.d;
        (back * n1 + back * back * n2 + n0) / (back * d1 + back * back * d2 + 1.0)
    }

    /// Returns the roots of z² + d1·z + d2.
    fn poles(&self) -> [Complex<f64>; 2] {
        let [d1, d2] = self.d;
        let root = Complex::new(d1 * d1 / 4.0 - d2, 0.0).sqrt();
        [root - d1 / 2.0, -root - d1 / 2.0]
    }

    /// Returns a bound of the rounding error: about ten roundings per cycle, which decay with the filter's own poles.
    fn bound(&self) -> f64 {
        let [p, q] = self.poles();
        10.0 * f64::EPSILON / ((1.0 - p.norm()) * (1.0 - q.norm()))
    }

    /// Returns the number of cycles after which the transient is below rounding.
    fn settle(&self) -> u32 {
        let [p, q] = self.poles();
        libm::ceil(45.0 / (1.0 - p.norm().max(q.norm()))) as u32
    }
}

fn bench(kind: u32, f0: f64, q: f64) -> Bench {
    let mut bench = Bench::new();
    bench.load::<Biquad>(&[]).unwrap();
    bench.set("biquad.0.type", kind);
    bench.set("biquad.0.f0", f0);
    bench.set("biquad.0.Q", q);
    bench.set("biquad.0.enable", true);
    bench.run("biquad.0", NS);
    assert!(bench.get::<bool>("biquad.0.valid"), "{kind} {f0} {q}");
    bench
}

fn coefficients(bench: &Bench) -> Coefficients {
    let [n0, n1, n2, d1, d2] =
        ["n0", "n1", "n2", "d1", "d2"].map(|name| bench.get(&format!("biquad.0.{name}")));
    Coefficients { n: [n0, n1, n2], d: [d1, d2] }
}

fn step(bench: &Bench, x: f64) -> f64 {
    bench.set("biquad.0.in", x);
    bench.run("biquad.0", NS);
    bench.get("biquad.0.out")
}

#[test]
fn sines_come_out_as_the_transfer_function_says() {
    for kind in [LOW_PASS, NOTCH] {
        for (f0, q) in
            [(50.0, FRAC_1_SQRT_2), (50.0, 2.0), (100.0, 0.5), (250.0, 1.0), (480.0, 0.7)]
        {
            let bench = bench(kind, f0, q);
            let c = coefficients(&bench);
            for hertz in [0, 1, 10, 30, 49, 50, 51, 75, 100, 150, 250, 333, 400, 480, 499] {
                let wanted = c.at(TAU * f64::from(hertz) / 1000.0);
                let (gain, phase) = response(|x| step(&bench, x), hertz, SAMPLES, c.settle());
                // At 0 Hz, the correlation with a constant counts both halves.
                let gain = if hertz == 0 { gain / 2.0 } else { gain };
                let off = (Complex::from_polar(gain, phase) - wanted).norm();
                assert!(off <= c.bound(), "{kind} {f0} {q}, {hertz} Hz: off by {off}");
            }
        }
    }
}

/// At the corner |H| is Q, for the maximally flat filter -3 dB, with a lag of a quarter turn.
#[test]
fn a_low_pass_has_its_corner() {
    for f0 in [5.0, 50.0, 125.0, 250.0, 400.0] {
        for q in [0.5, FRAC_1_SQRT_2, 1.0, 2.0] {
            let c = coefficients(&bench(LOW_PASS, f0, q));
            let corner = c.at(TAU * f0 * DT);
            let wanted = Complex::from_polar(q, -FRAC_PI_2);
            // Gain and phase change by at most 2Q²·Q per change of the angle w; the bilinear transform amplifies the
            // error of w by w/sin w.
            let w = TAU * f0 * DT;
            let steep = 4.0 * q * q * q.max(1.0) * w / libm::sin(w);
            let cancel = 8.0 * f64::EPSILON / (w * w);
            assert!((corner - wanted).norm() <= steep * OFF + cancel, "{f0} {q}: {corner}");
        }
    }
}

/// The notch has the gain 0 at its frequency, -3 dB where tan(w/2) is tan(w0/2)·(√(1 + 1/4Q²) ± 1/2Q), and the gain 1
/// far from it.
#[test]
fn a_notch_is_deep_and_as_wide_as_q_says() {
    for f0 in [5.0, 50.0, 125.0, 250.0, 400.0] {
        for q in [0.5, FRAC_1_SQRT_2, 1.0, 2.0] {
            let c = coefficients(&bench(NOTCH, f0, q));
            let w0 = TAU * f0 * DT;
            let deep = c.at(w0).norm();
            let cancel = 8.0 * f64::EPSILON / (w0 * w0);
            let bound = 4.0 * q * OFF * w0 / libm::sin(w0) + q * cancel;
            assert!(deep <= bound, "{f0} {q}: {deep}");
            for side in [-1.0, 1.0] {
                let edge = libm::hypot(1.0, 0.5 / q) + side * 0.5 / q;
                let w = 2.0 * libm::atan(libm::tan(w0 / 2.0) * edge);
                let is = c.at(w).norm();
                assert!(
                    (is - FRAC_1_SQRT_2).abs() <= bound + 4.0 * cancel,
                    "{f0} {q} {side}: {is}"
                );
            }
            let nyquist = c.at(PI).norm();
            let pole = c.poles()[0].norm();
            assert!(
                (nyquist - 1.0).abs() <= 8.0 * f64::EPSILON / (1.0 - pole),
                "{f0} {q}: {nyquist}"
            );
        }
    }
}

#[test]
fn what_is_at_rest_comes_through() {
    for kind in [LOW_PASS, NOTCH] {
        for (f0, q) in [(5.0, 0.5), (50.0, 1.0), (499.0, 2.0)] {
            let bench = bench(kind, f0, q);
            let c = coefficients(&bench);
            let is = (0..c.settle()).fold(0.0, |_, _| step(&bench, 3.0));
            assert!((is - 3.0).abs() <= 3.0 * c.bound(), "{kind} {f0} {q}: {is}");
        }
    }
}

/// Both poles lie in the unit circle if |d2| < 1 and |d1| < 1 + d2; for these designs their product is (1 - α)/(1 + α)
/// with α = sin w0/2Q.
#[test]
fn every_design_is_stable() {
    for kind in [LOW_PASS, NOTCH] {
        for tenths in 1..5000 {
            let (f0, q) = (f64::from(tenths) / 10.0, 0.5 + f64::from(tenths % 151) / 100.0);
            let c = coefficients(&bench(kind, f0, q));
            let [d1, d2] = c.d;
            assert!(d2.abs() < 1.0 && d1.abs() < 1.0 + d2, "{kind} {f0} {q}: {c:?}");
            let alpha = libm::sin(TAU * f0 * DT) / (2.0 * q);
            let wanted = (1.0 - alpha) / (1.0 + alpha);
            assert!(
                (d2 - wanted).abs() <= 2.0 * TAU * OFF + 4.0 * f64::EPSILON,
                "{kind} {f0} {q}: {d2}"
            );
        }
    }
}

/// The step response is H(1) plus, for each pole p, R·pⁿ with R = N(p)/((1 - p'/p)(1 - 1/p)), where p' is the other
/// pole.
#[test]
fn the_step_response_is_that_of_its_poles() {
    let own = Coefficients { n: [0.3, -0.2, 0.1], d: [-1.1, 0.24] };
    let mut designs = Vec::new();
    for kind in [LOW_PASS, NOTCH] {
        for (f0, q) in [(20.0, FRAC_1_SQRT_2), (100.0, 2.0), (300.0, 1.0)] {
            designs.push(bench(kind, f0, q));
        }
    }
    let by_hand = bench(0, 250.0, 1.0);
    for (name, value) in ["n0", "n1", "n2", "d1", "d2"].iter().zip([0.3, -0.2, 0.1, -1.1, 0.24]) {
        by_hand.set(&format!("biquad.0.{name}"), value);
    }
    assert_eq!(format!("{:?}", coefficients(&by_hand)), format!("{own:?}"));
    designs.push(by_hand);
    for bench in designs {
        let c = coefficients(&bench);
        let [n0, n1, n2] = c.n;
        let poles = c.poles();
        let residues = [(poles[0], poles[1]), (poles[1], poles[0])].map(|(p, other)| {
            let top = p.inv() * n1 + (p * p).inv() * n2 + n0;
            top / ((-other / p + 1.0) * (-p.inv() + 1.0))
        });
        let rest = c.of(Complex::from(1.0)).re;
        let size: f64 = residues.iter().map(|r| r.norm()).sum();
        for n in 0..400 {
            let fading: Complex<f64> = poles.iter().zip(residues).map(|(p, r)| r * p.powi(n)).sum();
            let wanted = rest + fading.re;
            let is = step(&bench, 1.0);
            // pⁿ is off by n roundings of p, and n·|p|ⁿ is at most 1/(e·(1 - |p|)).
            let bound = c.bound() * (1.0 + size);
            assert!((is - wanted).abs() <= bound, "{c:?}, run {n}: {is}, not {wanted}");
        }
    }
}
