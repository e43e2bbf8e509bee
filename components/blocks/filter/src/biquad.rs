//! `biquad`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

#[cfg(test)]
mod closed;

/// Value of π in the coefficients.
#[expect(clippy::approx_constant, reason = "the figures that users know come from this one")]
const PI: f64 = 3.141_592_653_589;

/// Second-order filter: low-pass, notch, or with coefficients set by the user.
///
/// A rising edge of `enable` computes the coefficients; while `enable` or `valid` is false, the input passes unchanged.
///
/// The transfer function is H(z) = (n0 + n1/z + n2/z²) / (1 + d1/z + d2/z²). The designs are the bilinear transforms of
/// 1/(s² + s/Q + 1) and (s² + 1)/(s² + s/Q + 1), prewarped at `f0`: there, a low-pass has the gain `Q` (-3 dB for
/// 0.7071) and a notch has the gain 0. Both have the gain 1 for a constant input.
///
/// # Example
///
/// ```hal
/// # What is at rest goes through a low-pass as it is.
/// loadrt biquad
/// loadrt threads name1=servo period1=1000000
/// addf biquad.0 servo
/// start
/// setp biquad.0.type 1
/// setp biquad.0.f0 50
/// setp biquad.0.enable 1
/// setp biquad.0.in 3
/// run 1s
/// getp biquad.0.valid # -> TRUE
/// getp biquad.0.out # -> 3
/// ```
#[derive(Component)]
pub(crate) struct Biquad {
    /// Input signal, in any unit.
    in_: In<f64>,
    /// Filtered signal, in the same unit.
    out: Out<f64>,
    /// TRUE enables the filter.
    enable: In<bool>,
    /// True if the coefficients make a filter.
    valid: Out<bool>,
    /// Filter type: 0 the coefficients as set by the user; 1 low-pass; 2 notch.
    #[hal(name = "type")]
    kind: In<u32>,
    /// Frequency of the filter, in hertz, at most half of the thread's.
    #[hal(default = 250.0)]
    f0: In<f64>,
    /// Quality factor of the filter, without unit, 0.5 to 2.
    #[hal(name = "Q", default = 7071.0 / 10_000.0)]
    q: In<f64>,
    /// Filter state for the next cycle, in the signal's unit.
    s1: Out<f64>,
    /// Filter state for the cycle after that, in the signal's unit.
    s2: Out<f64>,
    /// Coefficient of the last output; no unit.
    d1: ParamRw<f64>,
    /// Coefficient of the output before the last; no unit.
    d2: ParamRw<f64>,
    /// Coefficient of the input; no unit.
    #[hal(default = 1.0)]
    n0: ParamRw<f64>,
    /// Coefficient of the last input; no unit.
    n1: ParamRw<f64>,
    /// Coefficient of the input before the last; no unit.
    n2: ParamRw<f64>,
    #[state]
    was_enabled: bool,
}

impl Biquad {
    /// Computes the coefficients of the selected type. Returns false if there are none.
    fn design(&self, dt: f64) -> bool {
        let (f0, q) = (self.f0.get(), self.q.get());
        let kind = self.kind.get();
        if kind == 0 {
            return true;
        }
        if f0 > 1.0 / dt / 2.0 || !(0.5..=2.0).contains(&q) {
            return false;
        }
        let w = 2.0 * PI * f0 * dt;
        let (sin, cos) = (libm::sin(w), libm::cos(w));
        let alpha = sin / (2.0 * q);
        let (b0, b1) = match kind {
            1 => ((1.0 - cos) / 2.0, 1.0 - cos),
            2 => (1.0, -2.0 * cos),
            _ => return false,
        };
        let a0 = 1.0 + alpha;
        self.n0.set(b0 / a0);
        self.n1.set(b1 / a0);
        self.n2.set(b0 / a0);
        self.d1.set(-2.0 * cos / a0);
        self.d2.set((1.0 - alpha) / a0);
        self.s1.set(0.0);
        self.s2.set(0.0);
        true
    }
}

impl Update for Biquad {
    fn update(&mut self, period: Period) {
        let enable = self.enable.get();
        if enable && !self.was_enabled {
            self.valid.set(self.design(period.secs()));
        }
        self.was_enabled = enable;
        let input = self.in_.get();
        if !(enable && self.valid.get()) {
            self.out.set(input);
            return;
        }
        let out = input * self.n0.get() + self.s1.get();
        self.out.set(out);
        self.s1.set(input * self.n1.get() - out * self.d1.get() + self.s2.get());
        self.s2.set(input * self.n2.get() - out * self.d2.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Biquad;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Biquad>(include_str!("../traces/biquad.txt")), 410);
    }
}
