//! `bitslice`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Maximum number of bits.
const MAX: i64 = 32;
/// Default number of bits.
const DEFAULT: i64 = 16;

/// Bits of a number.
#[derive(Touch)]
pub(crate) struct Bitslice {
    number: In<u32>,
    bits: Vec<Out<bool>>,
}

impl Component for Bitslice {
    const NAME: &'static str = "bitslice";
    const DOC: &'static str = "The bits of a number, one by one.\n\n\
        `personality=` is how many of them, from the lowest: 1 to 32; 16 without it (LinuxCNC 2.9 makes none then).\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt bitslice personality=4\n\
        loadrt threads name1=servo period1=1000000\n\
        addf bitslice.0 servo\n\
        start\n\
        setp bitslice.0.in 9\n\
        run 1ms\n\
        getp bitslice.0.out-00 # -> TRUE\n\
        getp bitslice.0.out-01 # -> FALSE\n\
        getp bitslice.0.out-03 # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.size("Pin out-##", DEFAULT, MAX)?;
        let number = b.item("in", "The number.", 0)?;
        let bits: Result<Vec<_>, _> = (0..n)
            .map(|i| {
                b.item(
                    &format!("out-{i:02}"),
                    "Bit of the number at this position; 00 is the lowest.",
                    false,
                )
            })
            .collect();
        b.function("", "Splits the number into bits.", Self { number, bits: bits? })
    }
}

impl Update for Bitslice {
    fn update(&mut self, _: Period) {
        let number = self.number.get();
        for (i, bit) in self.bits.iter().enumerate() {
            bit.set(number >> i & 1 != 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Bitslice;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Bitslice>(include_str!("../traces/bitslice.txt")), 150);
    }

    #[test]
    fn no_more_than_32() {
        let refused = Bench::new().load::<Bitslice>(&["personality=33"]).unwrap_err();
        assert!(refused.starts_with(
            "Pin out-##: Requested size 33 exceeds max size 32: personality= is 1 to "
        ));
    }
}
