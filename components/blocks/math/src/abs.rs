//! `abs`.
use hal_component::{Component, In, Out, Period, Update};

/// Absolute value and sign of a number.
///
/// # Example
///
/// ```hal
/// loadrt abs
/// loadrt threads name1=servo period1=1000000
/// addf abs.0 servo
/// start
/// setp abs.0.in -2.5
/// run 1ms
/// getp abs.0.out # -> 2.5
/// getp abs.0.is-negative # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Abs {
    /// The number, in any unit.
    in_: In<f64>,
    /// Absolute value, in the same unit.
    out: Out<f64>,
    /// True when the number is negative or NaN.
    sign: Out<bool>,
    /// True when the number is above 0.000001.
    is_positive: Out<bool>,
    /// True when the number is below -0.000001.
    is_negative: Out<bool>,
}

/// Numbers closer to zero than this are neither positive nor negative.
const ZERO: f64 = 1e-6;

impl Update for Abs {
    fn update(&mut self, _: Period) {
        let x = self.in_.get();
        self.out.set(x.abs());
        self.sign.set(x < 0.0 || x.is_nan());
        self.is_positive.set(x > ZERO);
        self.is_negative.set(x < -ZERO);
    }
}

#[cfg(test)]
mod tests {
    use super::Abs;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Abs>(include_str!("../traces/abs.txt")), 21);
    }
}
