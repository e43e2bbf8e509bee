//! `scaled_s32_sums`.
use hal_component::{Component, In, Out, Period, Update, to_s32};

/// Sum of four numbers, each with a scale.
///
/// # Example
///
/// ```hal
/// # Two hand wheels of different steps move one thing.
/// loadrt scaled_s32_sums
/// loadrt threads name1=servo period1=1000000
/// addf scaled-s32-sums.0 servo
/// start
/// setp scaled-s32-sums.0.in0 100
/// setp scaled-s32-sums.0.in1 -7
/// setp scaled-s32-sums.0.scale1 2.5
/// run 1ms
/// getp scaled-s32-sums.0.out-f # -> 82.5
/// getp scaled-s32-sums.0.out-s # -> 82
/// ```
#[derive(Component)]
pub(crate) struct ScaledS32Sums {
    /// First number.
    in0: In<i32>,
    /// Second number.
    in1: In<i32>,
    /// Third number.
    in2: In<i32>,
    /// Fourth number.
    in3: In<i32>,
    /// Factor of the first number: units of the sum per count.
    #[hal(default = 1.0)]
    scale0: In<f64>,
    /// Factor of the second number: units of the sum per count.
    #[hal(default = 1.0)]
    scale1: In<f64>,
    /// Factor of the third number: units of the sum per count.
    #[hal(default = 1.0)]
    scale2: In<f64>,
    /// Factor of the fourth number: units of the sum per count.
    #[hal(default = 1.0)]
    scale3: In<f64>,
    /// Sum without its fraction; -2147483648 if it does not fit.
    out_s: Out<i32>,
    /// Sum, in the unit that the scales give.
    out_f: Out<f64>,
}

impl Update for ScaledS32Sums {
    fn update(&mut self, _: Period) {
        let part = |n: In<i32>, scale: In<f64>| f64::from(n.get()) * scale.get();
        let sum = part(self.in0, self.scale0)
            + part(self.in1, self.scale1)
            + part(self.in2, self.scale2)
            + part(self.in3, self.scale3);
        self.out_f.set(sum);
        self.out_s.set(to_s32(sum));
    }
}

#[cfg(test)]
mod tests {
    use super::ScaledS32Sums;
    use hal_bench::trace::replay;

    #[test]
    fn each_has_its_scale() {
        let rows = replay::<ScaledS32Sums>(
            "load scaled_s32_sums
             set scaled-s32-sums.0.scale1 10
             set scaled-s32-sums.0.scale2 0.5
             set scaled-s32-sums.0.scale3 -1
             run scaled-s32-sums.0
             in scaled-s32-sums.0.in0 scaled-s32-sums.0.in1 scaled-s32-sums.0.in2 scaled-s32-sums.0.in3
             out scaled-s32-sums.0.out-f scaled-s32-sums.0.out-s
             1 2 3 4 | 18.5 18
             0 0 -3 0 | -1.5 -1
             2147483647 1 0 0 | 2147483657 -2147483648
             set scaled-s32-sums.0.scale0 nan
             0 0 0 0 | nan -2147483648",
        );
        assert_eq!(rows, 4);
    }
}
