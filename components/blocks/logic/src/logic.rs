//! `logic`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

const AND: i64 = 0x100;
const OR: i64 = 0x200;
const XOR: i64 = 0x400;
const NAND: i64 = 0x800;
const NOR: i64 = 0x1000;
const MAX: i64 = 16;

/// Pins that the personality selects.
#[derive(Touch)]
pub(crate) struct Logic {
    inputs: Vec<In<bool>>,
    and: Option<Out<bool>>,
    or: Option<Out<bool>>,
    xor: Option<Out<bool>>,
    nand: Option<Out<bool>>,
    nor: Option<Out<bool>>,
}

impl Component for Logic {
    const NAME: &'static str = "logic";
    const DOC: &'static str = "Gate with up to 16 inputs and several outputs.\n\n\
        `personality=` is the number of inputs (0 to 16) plus one number for each output wanted: \
        0x100 `and`, 0x200 `or`, 0x400 `xor`, 0x800 `nand`, 0x1000 `nor`. `0x102` is a two-input \
        AND gate. The pins are `in-00`, `in-01` and so on, and the outputs that were asked for; \
        without a personality there are none.\n\n\
        # Pins\n\n\
        ```hal\n\
        loadrt logic personality=0x1c03\n\
        ```\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt logic personality=0x303\n\
        loadrt threads name1=servo period1=1000000\n\
        addf logic.0 servo\n\
        start\n\
        setp logic.0.in-00 1\n\
        setp logic.0.in-01 1\n\
        run 1ms\n\
        getp logic.0.and # -> FALSE\n\
        getp logic.0.or # -> TRUE\n\
        setp logic.0.in-02 1\n\
        run 1ms\n\
        getp logic.0.and # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let wanted = b.personality();
        let n = wanted & 0xff;
        let form = "personality= is 0 to 16 for the inputs, with 0x100 to 0x1000 for each output";
        if n > MAX {
            let text = format!("Pin in-##: Requested size {n} exceeds max size {MAX}: {form}");
            return Err(Error::new(text));
        }
        let mut inputs = Vec::new();
        for i in 0..n {
            inputs.push(b.item(&format!("in-{i:02}"), "A bit that is joined.", false)?);
        }
        let mut output = |bit: i64, name: &str, doc: &str| {
            (wanted & bit != 0).then(|| b.item(name, doc, false)).transpose()
        };
        let gate = Self {
            inputs,
            and: output(AND, "and", "True when every input is.")?,
            or: output(OR, "or", "True when at least one input is.")?,
            xor: output(XOR, "xor", "True when an odd number of inputs is.")?,
            nand: output(NAND, "nand", "False when every input is true.")?,
            nor: output(NOR, "nor", "False when at least one input is true.")?,
        };
        b.function("", "Computes the outputs.", gate)
    }
}

impl Update for Logic {
    fn update(&mut self, _: Period) {
        let (mut all, mut any, mut odd) = (true, false, false);
        for input in &self.inputs {
            let on = input.get();
            all &= on;
            any |= on;
            odd ^= on;
        }
        for (out, value) in [
            (&self.and, all),
            (&self.or, any),
            (&self.xor, odd),
            (&self.nand, !all),
            (&self.nor, !any),
        ] {
            if let Some(out) = out {
                out.set(value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Logic;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn every_output_as_recorded() {
        assert_eq!(replay::<Logic>(include_str!("../traces/logic.txt")), 27);
    }

    #[test]
    fn pins_follow_the_personality() {
        for (personality, wanted) in [
            ("0", vec![]),
            ("2", vec!["logic.0.in-00 bit IN", "logic.0.in-01 bit IN"]),
            ("0x100", vec!["logic.0.and bit OUT"]),
            ("0x2201", vec!["logic.0.in-00 bit IN", "logic.0.or bit OUT"]),
            ("0x1c00", vec!["logic.0.nand bit OUT", "logic.0.nor bit OUT", "logic.0.xor bit OUT"]),
        ] {
            let mut bench = Bench::new();
            bench.load::<Logic>(&[&format!("personality={personality}")]).unwrap();
            assert_eq!(bench.names(), wanted, "{personality}");
        }
    }

    #[test]
    fn sixteen_inputs_and_no_more() {
        let mut bench = Bench::new();
        bench.load::<Logic>(&["personality=0x110"]).unwrap();
        assert_eq!(bench.touches("logic.0").len(), 17);
        bench.run("logic.0", 1_000_000);
        assert!(!bench.get::<bool>("logic.0.and"));
        for i in 0..16 {
            bench.set(&format!("logic.0.in-{i:02}"), true);
        }
        bench.run("logic.0", 1_000_000);
        assert!(bench.get::<bool>("logic.0.and"));
        let refused = Bench::new().load::<Logic>(&["personality=0x111"]).unwrap_err();
        assert!(refused.starts_with(
            "Pin in-##: Requested size 17 exceeds max size 16: personality= is 0 to 16"
        ));
    }

    #[test]
    fn each_instance_has_its_own_personality() {
        let mut bench = Bench::new();
        bench.load::<Logic>(&["count=2", "personality=0x101,0x201"]).unwrap();
        assert_eq!(
            bench.names(),
            [
                "logic.0.and bit OUT",
                "logic.0.in-00 bit IN",
                "logic.1.in-00 bit IN",
                "logic.1.or bit OUT"
            ]
        );
    }
}
