//! `lowpass`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// First-order low-pass filter.
///
/// Each cycle adds `gain` · (`in` - `out`) to the output. This is the backward Euler form of τ·dy/dt = x - y, with
/// `gain` = T/(τ + T) for a time constant τ and a period T. After a step of the input, (1 - `gain`)ⁿ of the distance
/// remains after n cycles; behind a ramp of r per cycle, the output settles with a lag of r·(1 - `gain`)/`gain`.
///
/// # Example
///
/// ```hal
/// loadrt lowpass
/// loadrt threads name1=servo period1=1000000
/// addf lowpass.0 servo
/// start
/// setp lowpass.0.gain 0.5
/// setp lowpass.0.in 8
/// run 1ms
/// getp lowpass.0.out # -> 4
/// run 1ms
/// getp lowpass.0.out # -> 6
/// setp lowpass.0.load 1
/// run 1ms
/// getp lowpass.0.out # -> 8
/// ```
#[derive(Component)]
pub(crate) struct Lowpass {
    /// The number, in any unit.
    in_: In<f64>,
    /// While true, the output is the number.
    load: In<bool>,
    /// Filtered number, in the same unit.
    out: Out<f64>,
    /// Fraction of the distance to the input that the output covers in each cycle: 1 follows at once, 0 never. For a
    /// corner frequency of f hertz and a period of T seconds it is 1 - exp(-2πfT); the actual corner (-3 dB) is then 1
    /// % too high at an eighteenth of the thread's frequency, and closer below.
    gain: ParamRw<f64>,
}

impl Update for Lowpass {
    fn update(&mut self, _: Period) {
        let (x, out) = (self.in_.get(), self.out.get());
        let next = if self.load.get() { x } else { out + (x - out) * self.gain.get() };
        self.out.set(next);
    }
}

#[cfg(test)]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "how many runs")]
mod tests {
    use super::Lowpass;
    use hal_bench::{Bench, response, trace::replay};

    const NS: i64 = 1_000_000;
    const GAINS: [f64; 6] = [0.001, 0.02, 0.1, 0.5, 0.9, 1.0];

    /// Returns a filter at rest, and its error bound: a cycle's error is at most three roundings, of which the filter
    /// forgets `gain` per cycle.
    fn filter(gain: f64) -> (impl FnMut(f64) -> f64, f64) {
        let mut bench = Bench::new();
        bench.load::<Lowpass>(&[]).unwrap();
        bench.set("lowpass.0.gain", gain);
        let step = move |x: f64| {
            bench.set("lowpass.0.in", x);
            bench.run("lowpass.0", NS);
            bench.get("lowpass.0.out")
        };
        (step, 3.0 * f64::EPSILON / gain)
    }

    /// y[n] = 1 - (1 - g)^n solves y[n] = y[n-1] + g(1 - y[n-1]) from 0.
    #[test]
    fn the_step_response_is_a_geometric_series() {
        for gain in GAINS {
            let (mut step, bound) = filter(gain);
            for n in 1..=1000 {
                let (is, wanted) = (step(1.0), 1.0 - libm::pow(1.0 - gain, f64::from(n)));
                assert!((is - wanted).abs() <= bound, "gain {gain}, run {n}: {is}, not {wanted}");
            }
        }
    }

    /// H(z) = g/(1 - a/z) with a = 1 - g has |H|² = g²/(1 - 2a·cos w + a²).
    #[test]
    fn sines_come_out_as_the_transfer_function_says() {
        for gain in GAINS {
            let a = 1.0 - gain;
            for cycles in [1, 7, 40, 99, 200, 399] {
                let w = core::f64::consts::TAU * f64::from(cycles) / 800.0;
                let (re, im) = (1.0 - a * libm::cos(w), a * libm::sin(w));
                let (wanted, late) = (gain / libm::hypot(re, im), -libm::atan2(im, re));
                let (step, bound) = filter(gain);
                // The measurement rounds once per sample.
                let bound = bound + 800.0 * f64::EPSILON;
                // After 40 time constants, the rest of the transient is below rounding.
                let settle = libm::ceil(40.0 / gain) as u32;
                let (is, phase) = response(step, cycles, 800, settle);
                assert!((is - wanted).abs() <= bound, "gain {gain}, {w}: {is}, not {wanted}");
                assert!(
                    (phase - late).abs() <= bound / wanted,
                    "gain {gain}, {w}: {phase}, not {late}"
                );
            }
        }
    }

    /// |H|² is a half at sin(w/2) = g/(2√a), which for g = 1 - exp(-c) is sinh(c/2).
    #[test]
    fn the_corner_is_where_the_docs_say() {
        let an_eighteenth = core::f64::consts::TAU / 18.0;
        for corner in [0.001, 0.01, 0.1, an_eighteenth] {
            let gain = 1.0 - libm::exp(-corner);
            let a = 1.0 - gain;
            let at = 2.0 * libm::asin(gain / (2.0 * libm::sqrt(a)));
            let power = gain * gain / (1.0 - 2.0 * a * libm::cos(at) + a * a);
            // The denominator cancels to twice gain², with three roundings of about 1.
            let bound = 2.0 * f64::EPSILON / (gain * gain);
            assert!((power - 0.5).abs() <= bound, "{corner}: {power}");
            // The gain itself was rounded when it was subtracted from 1.
            let wanted = 2.0 * libm::asin(libm::sinh(corner / 2.0));
            assert!((at - wanted).abs() <= 2.0 * f64::EPSILON, "{corner}: {at}, not {wanted}");
            let above = wanted / corner - 1.0;
            assert!((0.0..0.0104).contains(&above), "{corner}: {above}");
        }
    }

    /// Behind x[n] = r·n, the output settles at r(n - a/g).
    #[test]
    fn it_follows_a_ramp_with_a_lag() {
        for gain in GAINS {
            let (mut step, bound) = filter(gain);
            let runs = libm::ceil(40.0 / gain);
            for n in 1..=runs as u32 {
                let is = step(0.25 * f64::from(n));
                if n == runs as u32 {
                    let lag = 0.25 * f64::from(n) - is;
                    let wanted = 0.25 * (1.0 - gain) / gain;
                    assert!(
                        (lag - wanted).abs() <= bound * 0.25 * runs,
                        "gain {gain}: {lag}, not {wanted}"
                    );
                }
            }
        }
    }

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Lowpass>(include_str!("../traces/lowpass.txt")), 100);
    }
}
