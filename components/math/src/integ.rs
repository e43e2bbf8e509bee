//! `integ`.
use crate::bounds::{larger, smaller};
use hal_component::{Component, In, Out, Period, Update};

/// Integral of a number over time.
///
/// # Example
///
/// ```hal
/// loadrt integ
/// loadrt threads name1=servo period1=1000000
/// addf integ.0 servo
/// start
/// setp integ.0.in 5
/// run 100ms
/// getp integ.0.out # -> 0.5
/// ```
#[derive(Component)]
pub(crate) struct Integ {
    /// The number, in units per second.
    in_: In<f64>,
    /// What the input is multiplied by, a number without a unit.
    #[hal(default = 1.0)]
    gain: In<f64>,
    /// While true, the integral is 0 (within the bounds).
    reset: In<bool>,
    /// Lowest integral, in units; it wins when the two cross.
    #[hal(default = -1e20)]
    min_: In<f64>,
    /// Highest integral, in units.
    #[hal(default = 1e20)]
    max_: In<f64>,
    /// The integral, in units, kept within the bounds at every run.
    out: Out<f64>,
}

impl Update for Integ {
    fn update(&mut self, period: Period) {
        let sum = if self.reset.get() {
            0.0
        } else {
            self.out.get() + self.gain.get() * self.in_.get() * period.secs()
        };
        self.out.set(larger(smaller(sum, self.max_.get()), self.min_.get()));
    }
}

#[cfg(test)]
mod tests {
    use super::Integ;
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Integ>(include_str!("../traces/integ.txt")), 143);
    }
}
