//! `scale`.
use hal_component::{Component, In, Out, Period, Update};

/// Gain and offset for a number.
///
/// # Example
///
/// ```hal
/// loadrt scale
/// loadrt threads name1=servo period1=1000000
/// addf scale.0 servo
/// start
/// setp scale.0.in 4
/// setp scale.0.gain 2.5
/// setp scale.0.offset 1
/// run 1ms
/// getp scale.0.out # -> 11
/// ```
#[derive(Component)]
pub(crate) struct Scale {
    /// The number, in any unit.
    in_: In<f64>,
    /// Gain, in the unit of `out` per unit of `in`; 0 by default.
    gain: In<f64>,
    /// Offset added to the product, in the unit of `out`.
    offset: In<f64>,
    /// `in` · `gain` + `offset`, in the resulting unit.
    out: Out<f64>,
}

impl Update for Scale {
    fn update(&mut self, _: Period) {
        self.out.set(self.in_.get() * self.gain.get() + self.offset.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Scale;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Scale>(include_str!("../traces/scale.txt")), 40);
    }
}
