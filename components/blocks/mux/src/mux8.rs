//! `mux8`.
use hal_component::{Component, In, Out, Period, Update};

/// Multiplexer for eight numbers.
///
/// The selectors form the index of the input, `sel0` + 2·`sel1` + 4·`sel2`.
///
/// # Example
///
/// ```hal
/// loadrt mux8
/// loadrt threads name1=servo period1=1000000
/// addf mux8.0 servo
/// start
/// setp mux8.0.in5 7
/// setp mux8.0.sel0 1
/// setp mux8.0.sel2 1
/// run 1ms
/// getp mux8.0.out # -> 7
/// ```
#[derive(Component)]
pub(crate) struct Mux8 {
    /// First number, in any unit.
    in0: In<f64>,
    /// Second number, in the same unit.
    in1: In<f64>,
    /// Third number, in the same unit.
    in2: In<f64>,
    /// Fourth number, in the same unit.
    in3: In<f64>,
    /// Fifth number, in the same unit.
    in4: In<f64>,
    /// Sixth number, in the same unit.
    in5: In<f64>,
    /// Seventh number, in the same unit.
    in6: In<f64>,
    /// Eighth number, in the same unit.
    in7: In<f64>,
    /// Selector bit with the value 1.
    sel0: In<bool>,
    /// Selector bit with the value 2.
    sel1: In<bool>,
    /// Selector bit with the value 4.
    sel2: In<bool>,
    /// Selected number, in the same unit.
    out: Out<f64>,
}

impl Update for Mux8 {
    fn update(&mut self, _: Period) {
        let chosen = match (self.sel2.get(), self.sel1.get(), self.sel0.get()) {
            (false, false, false) => &self.in0,
            (false, false, true) => &self.in1,
            (false, true, false) => &self.in2,
            (false, true, true) => &self.in3,
            (true, false, false) => &self.in4,
            (true, false, true) => &self.in5,
            (true, true, false) => &self.in6,
            (true, true, true) => &self.in7,
        };
        self.out.set(chosen.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Mux8;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Mux8>(include_str!("../traces/mux8.txt")), 100);
    }
}
