//! `weighted_sum`.
use hal_component::{
    Arg, Builder, Component, Error, In, Io, Out, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Sums of weighted bits.
pub(crate) struct WeightedSum;

impl Component for WeightedSum {
    const NAME: &'static str = "weighted_sum";
    const DOC: &'static str = "Sum of the weights of the bits that are true.\n\n\
        `wsum_sizes=3,8` makes `wsum.0` of three bits and `wsum.1` of eight. The weights are \
        initially 1, 2, 4, 8 and so on, so that the bits form a binary number. One function \
        computes all sums.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt weighted_sum wsum_sizes=3\n\
        loadrt threads name1=servo period1=1000000\n\
        addf process_wsums servo\n\
        start\n\
        setp wsum.0.bit.0.in 1\n\
        setp wsum.0.bit.2.in 1\n\
        run 1ms\n\
        getp wsum.0.sum # -> 5\n\
        setp wsum.0.bit.2.weight 100\n\
        setp wsum.0.offset -1\n\
        run 1ms\n\
        getp wsum.0.sum # -> 100\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::ints("wsum_sizes", "Number of bits of each sum; at most 8 sums.")
            .required()
            .within(1.0, 16.0)
            .at_most(8)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let sizes = b.arg_ints("wsum_sizes");
        let mut sums = Vec::new();
        for (i, n) in sizes.into_iter().enumerate() {
            let mut bits = Vec::new();
            for k in 0..n {
                let pin = |pin: &str| format!("wsum.{i}.bit.{k}.{pin}");
                let bit =
                    b.item(&pin("in"), "True adds the weight of this bit to the sum.", false)?;
                let weight = b.item(&pin("weight"), "Weight of this bit.", 1_i32 << k)?;
                bits.push((bit, weight));
            }
            let doc = "While true, the sum stays.";
            let hold = b.item(&format!("wsum.{i}.hold"), doc, false)?;
            let doc = "Sum when no bit is true.";
            let offset = b.item(&format!("wsum.{i}.offset"), doc, 0)?;
            let doc = "The offset and the weights of all bits that are true; it wraps at 32 bits.";
            let sum = b.item(&format!("wsum.{i}.sum"), doc, 0)?;
            sums.push(Sum { bits, hold, offset, sum });
        }
        b.function("process_wsums", "Computes all sums.", Sums { sums })
    }
}

#[derive(Touch)]
struct Sums {
    sums: Vec<Sum>,
}

#[derive(Touch)]
struct Sum {
    bits: Vec<(In<bool>, Io<i32>)>,
    hold: In<bool>,
    offset: Io<i32>,
    sum: Out<i32>,
}

impl Update for Sums {
    fn update(&mut self, _: Period) {
        for s in self.sums.iter().filter(|s| !s.hold.get()) {
            let weights = s.bits.iter().filter(|(bit, _)| bit.get()).map(|(_, w)| w.get());
            s.sum.set(weights.fold(s.offset.get(), i32::wrapping_add));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::WeightedSum;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn a_binary_number_and_more() {
        let rows = replay::<WeightedSum>(
            "load weighted_sum wsum_sizes=1,3
             run process_wsums
             in wsum.1.bit.0.in wsum.1.bit.1.in wsum.1.bit.2.in wsum.1.hold
             out wsum.1.sum
             0 0 0 0 | 0
             1 0 1 0 | 5
             0 1 0 1 | 5
             0 1 0 0 | 2
             set wsum.1.offset -10
             1 1 1 0 | -3
             set wsum.1.bit.0.weight 2147483647
             set wsum.1.offset 1
             1 0 0 0 | -2147483648",
        );
        assert_eq!(rows, 6);
    }

    #[test]
    fn sizes() {
        let mut bench = Bench::new();
        bench.load::<WeightedSum>(&["wsum_sizes=16"]).unwrap();
        assert_eq!(bench.get::<i32>("wsum.0.bit.15.weight"), 32768);
        for wrong in ["wsum_sizes=0", "wsum_sizes=3,17"] {
            let mut bench = Bench::new();
            let said = bench.load::<WeightedSum>(&[wrong]).unwrap_err();
            assert!(said.contains("out of range for parameter `wsum_sizes="), "{said}");
            assert!(bench.names().is_empty());
        }
    }
}
