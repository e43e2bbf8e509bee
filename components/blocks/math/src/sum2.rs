//! `sum2`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Sum of two numbers, each with a gain, and an offset.
///
/// # Example
///
/// ```hal
/// loadrt sum2
/// loadrt threads name1=servo period1=1000000
/// addf sum2.0 servo
/// start
/// setp sum2.0.in0 7
/// setp sum2.0.in1 2
/// setp sum2.0.gain1 -3
/// setp sum2.0.offset 0.5
/// run 1ms
/// getp sum2.0.out # -> 1.5
/// ```
#[derive(Component)]
pub(crate) struct Sum2 {
    /// First number, in any unit.
    in0: In<f64>,
    /// Second number, in any unit.
    in1: In<f64>,
    /// `in0` · `gain0` + `in1` · `gain1` + `offset`, in the resulting unit.
    out: Out<f64>,
    /// Gain of `in0`, in the unit of `out` per unit of `in0`; -1 subtracts it.
    #[hal(default = 1.0)]
    gain0: ParamRw<f64>,
    /// Gain of `in1`, in the unit of `out` per unit of `in1`; -1 subtracts it.
    #[hal(default = 1.0)]
    gain1: ParamRw<f64>,
    /// Offset added to the sum, in the unit of `out`.
    offset: ParamRw<f64>,
}

impl Update for Sum2 {
    fn update(&mut self, _: Period) {
        let (a, b) = (self.in0.get() * self.gain0.get(), self.in1.get() * self.gain1.get());
        self.out.set(a + b + self.offset.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Sum2;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Sum2>(include_str!("../traces/sum2.txt")), 80);
    }
}
