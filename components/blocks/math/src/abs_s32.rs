//! `abs_s32`.
use hal_component::{Component, In, Out, Period, Update};

/// Absolute value and sign of a 32-bit number.
///
/// # Example
///
/// ```hal
/// loadrt abs_s32
/// loadrt threads name1=servo period1=1000000
/// addf abs-s32.0 servo
/// start
/// setp abs-s32.0.in -7
/// run 1ms
/// getp abs-s32.0.out # -> 7
/// getp abs-s32.0.sign # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct AbsS32 {
    /// The number.
    in_: In<i32>,
    /// Absolute value; for -2147483648 it is -2147483648, because 2147483648 does not fit.
    out: Out<i32>,
    /// True when the number is negative.
    sign: Out<bool>,
    /// True when the number is above zero.
    is_positive: Out<bool>,
    /// True when the number is below zero.
    is_negative: Out<bool>,
}

impl Update for AbsS32 {
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
    use super::AbsS32;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<AbsS32>(include_str!("../traces/abs_s32.txt")), 9);
    }
}
