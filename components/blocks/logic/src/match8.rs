//! `match8`.
use hal_component::{Component, In, Out, Period, Update};

/// Comparator of two 8-bit numbers for equality.
///
/// Several can be chained: the `out` of one is the `in` of the next.
///
/// # Example
///
/// ```hal
/// loadrt match8
/// loadrt threads name1=servo period1=1000000
/// addf match8.0 servo
/// start
/// setp match8.0.a0 1
/// run 1ms
/// getp match8.0.out # -> FALSE
/// setp match8.0.b0 1
/// run 1ms
/// getp match8.0.out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Match8 {
    /// TRUE enables the comparison; FALSE makes the output false.
    #[hal(default = true)]
    in_: In<bool>,
    /// Bit 0 of the first number.
    a0: In<bool>,
    /// Bit 1 of the first number.
    a1: In<bool>,
    /// Bit 2 of the first number.
    a2: In<bool>,
    /// Bit 3 of the first number.
    a3: In<bool>,
    /// Bit 4 of the first number.
    a4: In<bool>,
    /// Bit 5 of the first number.
    a5: In<bool>,
    /// Bit 6 of the first number.
    a6: In<bool>,
    /// Bit 7 of the first number.
    a7: In<bool>,
    /// Bit 0 of the second number.
    b0: In<bool>,
    /// Bit 1 of the second number.
    b1: In<bool>,
    /// Bit 2 of the second number.
    b2: In<bool>,
    /// Bit 3 of the second number.
    b3: In<bool>,
    /// Bit 4 of the second number.
    b4: In<bool>,
    /// Bit 5 of the second number.
    b5: In<bool>,
    /// Bit 6 of the second number.
    b6: In<bool>,
    /// Bit 7 of the second number.
    b7: In<bool>,
    /// True when `in` is true and each bit of the first number equals that of the second.
    out: Out<bool>,
}

impl Update for Match8 {
    fn update(&mut self, _: Period) {
        let pairs = [
            (&self.a0, &self.b0),
            (&self.a1, &self.b1),
            (&self.a2, &self.b2),
            (&self.a3, &self.b3),
            (&self.a4, &self.b4),
            (&self.a5, &self.b5),
            (&self.a6, &self.b6),
            (&self.a7, &self.b7),
        ];
        self.out.set(self.in_.get() && pairs.iter().all(|(a, b)| a.get() == b.get()));
    }
}

#[cfg(test)]
mod tests {
    use super::Match8;
    use hal_bench::trace::replay;

    #[test]
    fn each_bit_as_recorded() {
        assert_eq!(replay::<Match8>(include_str!("../traces/match8.txt")), 60);
    }
}
