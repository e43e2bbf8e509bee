//! `limit2`.
use crate::bounds::within;
use hal_component::{Component, In, Out, Period, Update};

/// Limits a number to a range, and its rate of change.
///
/// # Example
///
/// ```hal
/// loadrt limit2
/// loadrt threads name1=servo period1=1000000
/// addf limit2.0 servo
/// start
/// setp limit2.0.maxv 100
/// setp limit2.0.in 12
/// run 10ms
/// getp limit2.0.out # -> 1
/// setp limit2.0.load 1
/// run 1ms
/// getp limit2.0.out # -> 12
/// ```
#[derive(Component)]
pub(crate) struct Limit2 {
    /// The number, in any unit.
    in_: In<f64>,
    /// While true, the output jumps to the number (within the range) at once.
    load: In<bool>,
    /// Minimum of the output, in units; it wins if the bounds are crossed and the number is below it.
    #[hal(default = -1e20)]
    min_: In<f64>,
    /// Maximum of the output, in units.
    #[hal(default = 1e20)]
    max_: In<f64>,
    /// Maximum rate of change, in units per second; positive. If the output is outside the range, it also returns no
    /// faster than this.
    #[hal(default = 1e20)]
    maxv: In<f64>,
    /// Limited number, in the same unit.
    out: Out<f64>,
}

impl Update for Limit2 {
    fn update(&mut self, period: Period) {
        let goal = within(self.in_.get(), self.min_.get(), self.max_.get());
        if self.load.get() {
            self.out.set(goal);
            return;
        }
        let (old, step) = (self.out.get(), self.maxv.get() * period.secs());
        self.out.set(within(goal, old - step, old + step));
    }
}

#[cfg(test)]
mod tests {
    use super::Limit2;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Limit2>(include_str!("../traces/limit2.txt")), 299);
    }
}
