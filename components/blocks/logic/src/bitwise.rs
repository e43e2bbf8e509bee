//! `bitwise`.
use hal_component::{Component, In, Out, Period, Update};

/// Bitwise logic of two numbers.
///
/// # Example
///
/// ```hal
/// loadrt bitwise
/// loadrt threads name1=servo period1=1000000
/// addf bitwise.0 servo
/// start
/// setp bitwise.0.in0 12
/// setp bitwise.0.in1 10
/// run 1ms
/// getp bitwise.0.out-and # -> 8
/// getp bitwise.0.out-or # -> 14
/// getp bitwise.0.out-xor # -> 6
/// getp bitwise.0.out-nor # -> 4294967281
/// ```
#[derive(Component)]
pub(crate) struct Bitwise {
    /// First number.
    in0: In<u32>,
    /// Second number.
    in1: In<u32>,
    /// Bits that are set in both numbers.
    out_and: Out<u32>,
    /// Bits that are set in at least one number.
    out_or: Out<u32>,
    /// Bits that are set in exactly one number.
    out_xor: Out<u32>,
    /// Bits that are not set in both numbers.
    out_nand: Out<u32>,
    /// Bits that are set in neither number.
    out_nor: Out<u32>,
    /// Bits that are equal in both numbers.
    out_xnor: Out<u32>,
}

impl Update for Bitwise {
    fn update(&mut self, _: Period) {
        let (a, b) = (self.in0.get(), self.in1.get());
        self.out_and.set(a & b);
        self.out_or.set(a | b);
        self.out_xor.set(a ^ b);
        self.out_nand.set(!(a & b));
        self.out_nor.set(!(a | b));
        self.out_xnor.set(!(a ^ b));
    }
}

#[cfg(test)]
mod tests {
    use super::Bitwise;
    use hal_bench::trace::replay;

    #[test]
    fn every_pair_of_bits() {
        let rows = replay::<Bitwise>(
            "load bitwise
             run bitwise.0
             in bitwise.0.in0 bitwise.0.in1
             out bitwise.0.out-and bitwise.0.out-or bitwise.0.out-xor bitwise.0.out-nand bitwise.0.out-nor bitwise.0.out-xnor
             12 10 | 8 14 6 4294967287 4294967281 4294967289
             0 0 | 0 0 0 4294967295 4294967295 4294967295
             4294967295 0 | 0 4294967295 4294967295 4294967295 0 0
             4294967295 4294967295 | 4294967295 4294967295 0 0 0 4294967295",
        );
        assert_eq!(rows, 4);
    }
}
