//! `lut5`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Lookup table for any function of five bits.
///
/// The inputs form an index, `in-0` + 2·`in-1` + 4·`in-2` + 8·`in-3` + 16·`in-4`; the output is the bit of `function`
/// with that index. `0x80000000` is a five-input AND, `0xfffffffe` an OR.
///
/// # Example
///
/// ```hal
/// # True when the first two bits are, and the third is not.
/// loadrt lut5
/// loadrt threads name1=servo period1=1000000
/// addf lut5.0 servo
/// start
/// setp lut5.0.function 0x8
/// setp lut5.0.in-0 1
/// setp lut5.0.in-1 1
/// run 1ms
/// getp lut5.0.out # -> TRUE
/// setp lut5.0.in-2 1
/// run 1ms
/// getp lut5.0.out # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Lut5 {
    /// Input with the value 1.
    in_0: In<bool>,
    /// Input with the value 2.
    in_1: In<bool>,
    /// Input with the value 4.
    in_2: In<bool>,
    /// Input with the value 8.
    in_3: In<bool>,
    /// Input with the value 16.
    in_4: In<bool>,
    /// Selected bit of the table.
    out: Out<bool>,
    /// Table: bit n is the output for the index n.
    function: ParamRw<u32>,
}

impl Update for Lut5 {
    fn update(&mut self, _: Period) {
        let inputs = [&self.in_4, &self.in_3, &self.in_2, &self.in_1, &self.in_0];
        let n = inputs.iter().fold(0, |n, input| (n << 1) | u32::from(input.get()));
        self.out.set((self.function.get() >> n) & 1 != 0);
    }
}

#[cfg(test)]
mod tests {
    use super::Lut5;
    use hal_bench::trace::replay;

    #[test]
    fn every_number_as_recorded() {
        assert_eq!(replay::<Lut5>(include_str!("../traces/lut5.txt")), 64);
    }
}
