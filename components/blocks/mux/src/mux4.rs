//! `mux4`.
use hal_component::{Component, In, Out, Period, Update};

/// Multiplexer for four numbers.
///
/// The selectors form the index of the input, `sel0` + 2·`sel1`.
///
/// # Example
///
/// ```hal
/// loadrt mux4
/// loadrt threads name1=servo period1=1000000
/// addf mux4.0 servo
/// start
/// setp mux4.0.in3 7
/// setp mux4.0.sel0 1
/// setp mux4.0.sel1 1
/// run 1ms
/// getp mux4.0.out # -> 7
/// ```
#[derive(Component)]
pub(crate) struct Mux4 {
    /// First number, in any unit.
    in0: In<f64>,
    /// Second number, in the same unit.
    in1: In<f64>,
    /// Third number, in the same unit.
    in2: In<f64>,
    /// Fourth number, in the same unit.
    in3: In<f64>,
    /// Selector bit with the value 1.
    sel0: In<bool>,
    /// Selector bit with the value 2.
    sel1: In<bool>,
    /// Selected number, in the same unit.
    out: Out<f64>,
}

impl Update for Mux4 {
    fn update(&mut self, _: Period) {
        let chosen = match (self.sel1.get(), self.sel0.get()) {
            (false, false) => &self.in0,
            (false, true) => &self.in1,
            (true, false) => &self.in2,
            (true, true) => &self.in3,
        };
        self.out.set(chosen.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Mux4;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Mux4>(include_str!("../traces/mux4.txt")), 60);
    }
}
