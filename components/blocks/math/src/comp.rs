//! `comp`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Comparator of two numbers, with hysteresis.
///
/// # Example
///
/// ```hal
/// loadrt comp
/// loadrt threads name1=servo period1=1000000
/// addf comp.0 servo
/// start
/// setp comp.0.in1 1
/// run 1ms
/// getp comp.0.out # -> TRUE
/// setp comp.0.hyst 4
/// setp comp.0.in0 2
/// run 1ms
/// getp comp.0.equal # -> TRUE
/// getp comp.0.out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Comp {
    /// First number, in any unit.
    in0: In<f64>,
    /// Second number, in the same unit.
    in1: In<f64>,
    /// Becomes true when `in1` is above `in0` by more than half of `hyst`, and false when it is below by more than
    /// that; in between it keeps its value.
    out: Out<bool>,
    /// True when the numbers differ by no more than half of `hyst`.
    equal: Out<bool>,
    /// Hysteresis, in the same unit: the width of the range in which the numbers count as equal.
    hyst: ParamRw<f64>,
}

impl Update for Comp {
    fn update(&mut self, _: Period) {
        let (more, half) = (self.in1.get() - self.in0.get(), self.hyst.get() / 2.0);
        let (below, above) = (more < -half, more > half);
        if below || above {
            self.out.set(!below);
        }
        self.equal.set(!below && !above);
    }
}

#[cfg(test)]
mod tests {
    use super::Comp;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Comp>(include_str!("../traces/comp.txt")), 70);
    }
}
