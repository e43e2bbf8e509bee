//! `bitmerge`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Maximum number of bits.
const MAX: i64 = 32;
/// Default number of bits.
const DEFAULT: i64 = 16;

/// Number made of bits.
#[derive(Touch)]
pub(crate) struct Bitmerge {
    bits: Vec<In<bool>>,
    number: Out<u32>,
}

impl Component for Bitmerge {
    const NAME: &'static str = "bitmerge";
    const DOC: &'static str = "A number from its bits.\n\n\
        `personality=` is how many of them, from the lowest: 1 to 32; 16 without it. `bitslice` \
        is the inverse.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt bitmerge personality=4\n\
        loadrt threads name1=servo period1=1000000\n\
        addf bitmerge.0 servo\n\
        start\n\
        setp bitmerge.0.in-00 1\n\
        setp bitmerge.0.in-03 1\n\
        run 1ms\n\
        getp bitmerge.0.out # -> 9\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.size("Pin in-##", DEFAULT, MAX)?;
        let bits: Result<Vec<_>, _> = (0..n)
            .map(|i| {
                b.item(&format!("in-{i:02}"), &format!("The bit worth {}.", 1_u64 << i), false)
            })
            .collect();
        let number = b.item("out", "The number.", 0)?;
        b.function("", "Combines the bits into the number.", Self { bits: bits?, number })
    }
}

impl Update for Bitmerge {
    fn update(&mut self, _: Period) {
        let bits = self.bits.iter().enumerate();
        self.number.set(bits.fold(0, |n, (i, bit)| n | u32::from(bit.get()) << i));
    }
}

#[cfg(test)]
mod tests {
    use super::Bitmerge;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn each_bit_has_its_worth() {
        let rows = replay::<Bitmerge>(
            "load bitmerge personality=3
             run bitmerge.0
             in bitmerge.0.in-00 bitmerge.0.in-01 bitmerge.0.in-02
             out bitmerge.0.out
             0 0 0 | 0
             1 0 0 | 1
             0 1 0 | 2
             1 0 1 | 5
             1 1 1 | 7",
        );
        assert_eq!(rows, 5);
    }

    #[test]
    fn up_to_32() {
        let mut bench = Bench::new();
        bench.load::<Bitmerge>(&["personality=32"]).unwrap();
        bench.set("bitmerge.0.in-31", true);
        bench.run("bitmerge.0", 1_000_000);
        assert_eq!(bench.get::<u32>("bitmerge.0.out"), 1 << 31);
        let refused = Bench::new().load::<Bitmerge>(&["personality=33"]).unwrap_err();
        assert!(refused.starts_with(
            "Pin in-##: Requested size 33 exceeds max size 32: personality= is 1 to "
        ));
    }
}
