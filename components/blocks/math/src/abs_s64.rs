//! `abs_s64`.
use hal_component::{Component, In, Out, Period, Update};

/// Absolute value and sign of a 64-bit number.
///
/// # Example
///
/// ```hal
/// loadrt abs_s64
/// loadrt threads name1=servo period1=1000000
/// addf abs-s64.0 servo
/// start
/// setp abs-s64.0.in -9000000000
/// run 1ms
/// getp abs-s64.0.out # -> 9000000000
/// getp abs-s64.0.sign # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct AbsS64 {
    /// The number.
    in_: In<i64>,
    /// Absolute value; for the lowest number it is the number itself, because its opposite does not fit.
    out: Out<i64>,
    /// True when the number is negative.
    sign: Out<bool>,
    /// True when the number is above zero.
    is_positive: Out<bool>,
    /// True when the number is below zero.
    is_negative: Out<bool>,
}

impl Update for AbsS64 {
    fn update(&mut self, _: Period) {
        let x = self.in_.get();
        self.out.set(x.wrapping_abs());
        self.sign.set(x < 0);
        self.is_positive.set(x > 0);
        self.is_negative.set(x < 0);
    }
}

#[cfg(test)]
mod tests {
    use super::AbsS64;
    use hal_bench::trace::replay;

    #[test]
    fn every_kind_of_number() {
        let rows = replay::<AbsS64>(
            "load abs_s64
             run abs-s64.0
             in abs-s64.0.in
             out abs-s64.0.out abs-s64.0.sign abs-s64.0.is-positive abs-s64.0.is-negative
             0 | 0 0 0 0
             5 | 5 0 1 0
             -5 | 5 1 0 1
             9223372036854775807 | 9223372036854775807 0 1 0
             -9223372036854775807 | 9223372036854775807 1 0 1
             -9223372036854775808 | -9223372036854775808 1 0 1",
        );
        assert_eq!(rows, 6);
    }
}
