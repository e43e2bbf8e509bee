//! `minmax`.
use crate::bounds::{larger, smaller};
use hal_component::{Component, In, Out, Period, Update};

/// Minimum and maximum of a number so far.
///
/// # Example
///
/// ```hal
/// loadrt minmax
/// loadrt threads name1=servo period1=1000000
/// addf minmax.0 servo
/// start
/// setp minmax.0.in 5
/// run 1ms
/// setp minmax.0.in -3
/// run 1ms
/// getp minmax.0.max # -> 5
/// getp minmax.0.min # -> -3
/// setp minmax.0.reset 1
/// run 1ms
/// getp minmax.0.max # -> -3
/// ```
#[derive(Component)]
pub(crate) struct Minmax {
    /// The number, in any unit.
    in_: In<f64>,
    /// While true, both outputs equal the number, so that the search restarts.
    reset: In<bool>,
    /// Minimum so far, in the same unit; at most 0 before the first reset.
    min_: Out<f64>,
    /// Maximum so far, in the same unit; at least 0 before the first reset.
    max_: Out<f64>,
}

impl Update for Minmax {
    fn update(&mut self, _: Period) {
        let x = self.in_.get();
        if self.reset.get() {
            self.min_.set(x);
            self.max_.set(x);
            return;
        }
        self.min_.set(smaller(self.min_.get(), x));
        self.max_.set(larger(self.max_.get(), x));
    }
}

#[cfg(test)]
mod tests {
    use super::Minmax;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Minmax>(include_str!("../traces/minmax.txt")), 69);
    }
}
