//! `mult2`.
use hal_component::{Component, In, Out, Period, Update};

/// Product of two numbers.
///
/// # Example
///
/// ```hal
/// loadrt mult2
/// loadrt threads name1=servo period1=1000000
/// addf mult2.0 servo
/// start
/// setp mult2.0.in0 7
/// setp mult2.0.in1 -2
/// run 1ms
/// getp mult2.0.out # -> -14
/// ```
#[derive(Component)]
pub(crate) struct Mult2 {
    /// First number, in any unit.
    in0: In<f64>,
    /// Second number, in any unit.
    in1: In<f64>,
    /// `in0` · `in1`, in the product of their units.
    out: Out<f64>,
}

impl Update for Mult2 {
    fn update(&mut self, _: Period) {
        self.out.set(self.in0.get() * self.in1.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Mult2;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Mult2>(include_str!("../traces/mult2.txt")), 40);
    }
}
