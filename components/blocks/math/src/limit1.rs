//! `limit1`.
use crate::bounds::{larger, smaller};
use hal_component::{Component, In, Out, Period, Update};

/// Limits a number to a range.
///
/// # Example
///
/// ```hal
/// loadrt limit1
/// loadrt threads name1=servo period1=1000000
/// addf limit1.0 servo
/// start
/// setp limit1.0.max 10
/// setp limit1.0.in 12
/// run 1ms
/// getp limit1.0.out # -> 10
/// ```
#[derive(Component)]
pub(crate) struct Limit1 {
    /// The number, in any unit.
    in_: In<f64>,
    /// Minimum of the output, in the number's unit.
    #[hal(default = -1e20)]
    min_: In<f64>,
    /// Maximum of the output, in the number's unit; it wins if the bounds are crossed.
    #[hal(default = 1e20)]
    max_: In<f64>,
    /// Limited number, in its unit. A bound that is NaN has no effect, and an input that is NaN passes unchanged.
    out: Out<f64>,
}

impl Update for Limit1 {
    fn update(&mut self, _: Period) {
        let raised = larger(self.in_.get(), self.min_.get());
        self.out.set(smaller(raised, self.max_.get()));
    }
}

#[cfg(test)]
mod tests {
    use super::Limit1;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Limit1>(include_str!("../traces/limit1.txt")), 72);
    }
}
