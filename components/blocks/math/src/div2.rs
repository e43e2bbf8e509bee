//! `div2`.
use crate::bounds::away;
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Quotient of two numbers.
///
/// # Example
///
/// ```hal
/// loadrt div2
/// loadrt threads name1=servo period1=1000000
/// addf div2.0 servo
/// start
/// setp div2.0.in0 7
/// setp div2.0.in1 2
/// run 1ms
/// getp div2.0.out # -> 3.5
/// ```
#[derive(Component)]
pub(crate) struct Div2 {
    /// Dividend, in any unit.
    in0: In<f64>,
    /// Divisor, in any unit.
    in1: In<f64>,
    /// `in0` / `in1`, in the quotient of their units; `deadband` keeps the divisor away from zero.
    out: Out<f64>,
    /// Minimum magnitude of the divisor, in its unit; a smaller divisor is replaced by this with its sign (zero counts
    /// as positive). A value below 1e-12 is set to 1e-12.
    deadband: ParamRw<f64>,
}

impl Update for Div2 {
    fn update(&mut self, _: Period) {
        self.out.set(self.in0.get() / away(self.in1.get(), &self.deadband));
    }
}

#[cfg(test)]
mod tests {
    use super::Div2;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Div2>(include_str!("../traces/div2.txt")), 52);
    }
}
