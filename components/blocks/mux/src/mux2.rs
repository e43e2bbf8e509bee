//! `mux2`.
use hal_component::{Component, In, Out, Period, Update};

/// Multiplexer for two numbers.
///
/// # Example
///
/// ```hal
/// loadrt mux2
/// loadrt threads name1=servo period1=1000000
/// addf mux2.0 servo
/// start
/// setp mux2.0.in1 5
/// run 1ms
/// getp mux2.0.out # -> 0
/// setp mux2.0.sel 1
/// run 1ms
/// getp mux2.0.out # -> 5
/// ```
#[derive(Component)]
pub(crate) struct Mux2 {
    /// First number, in any unit.
    in0: In<f64>,
    /// Second number, in the same unit.
    in1: In<f64>,
    /// Selector: FALSE for `in0`, TRUE for `in1`.
    sel: In<bool>,
    /// Selected number, in the same unit.
    out: Out<f64>,
}

impl Update for Mux2 {
    fn update(&mut self, _: Period) {
        let chosen = if self.sel.get() { &self.in1 } else { &self.in0 };
        self.out.set(chosen.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Mux2;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Mux2>(include_str!("../traces/mux2.txt")), 40);
    }
}
