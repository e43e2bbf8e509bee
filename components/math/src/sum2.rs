//! `sum2`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Sum of two numbers, each with a gain, and an offset.
#[derive(Component)]
pub(crate) struct Sum2 {
    /// First number.
    in0: In<f64>,
    /// Second number.
    in1: In<f64>,
    /// `in0` · `gain0` + `in1` · `gain1` + `offset`.
    out: Out<f64>,
    /// Gain of `in0`; -1 subtracts it.
    #[hal(default = 1.0)]
    gain0: ParamRw<f64>,
    /// Gain of `in1`; -1 subtracts it.
    #[hal(default = 1.0)]
    gain1: ParamRw<f64>,
    /// Added to the sum.
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
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Sum2>(include_str!("../traces/sum2.txt")), 80);
    }
}
