//! `mux_generic`.
use crate::{
    config::{Config, read},
    kind::{Goal, Source},
    selector::Selector,
};
use hal_component::{
    Arg, Builder, Component, Error, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Multiplexers of any size and type.
pub(crate) struct MuxGeneric;

impl Component for MuxGeneric {
    const NAME: &'static str = "mux_generic";
    const DOC: &'static str = "Selects one of several values, and converts it to any type.\n\n\
        `config=ff4,bu12` makes `mux-gen.00`, one of four floats as a float, and `mux-gen.01`, one \
        of twelve bits as an unsigned number. The letters are `b` bit, `f` float, `s` s32, `u` u32; \
        one alone stands for both. Each has 2 to 1024 inputs. Selector bits exist if the number \
        of inputs is a power of two, or one more; `sel-int` is added to them.\n\n\
        A value out of its output's range becomes the nearest one; a float beyond 2e-7 becomes a \
        true bit, and NaN becomes false, 0, or, as s32, -2147483648. Floats are kept at \
        -2147483647 or more.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt mux_generic config=fs3\n\
        loadrt threads name1=servo period1=1000000\n\
        addf mux-gen.00 servo\n\
        start\n\
        setp mux-gen.00.in-float-01 2.75\n\
        setp mux-gen.00.in-float-02 -1e12\n\
        setp mux-gen.00.sel-int 1\n\
        run 1ms\n\
        getp mux-gen.00.out-s32 # -> 2\n\
        setp mux-gen.00.sel-int 7\n\
        run 1ms\n\
        getp mux-gen.00.selected # -> 7\n\
        getp mux-gen.00.out-s32 # -> -2147483647\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::texts(
        "config",
        "For each instance: the letters of its types, and the number of inputs, such as ff4.",
    )
    .required()
    .at_most(100)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let texts = b.arg_texts("config");
        let list: Result<Vec<Config>, _> = texts.iter().map(String::as_str).map(read).collect();
        for (i, Config { from, to, size }) in list?.into_iter().enumerate() {
            let name = format!("mux-gen.{i:02}");
            let selector = Selector::declare(b, &name, size)?;
            let mut inputs = Vec::new();
            for i in 0..size {
                let pin = format!("{name}.in-{}-{i:02}", from.word());
                inputs.push(from.input(b, &pin, "Selectable value, in any unit.")?);
            }
            let doc = "The selected value, in its unit, converted to this type.";
            let output = to.output(b, &format!("{name}.out-{}", to.word()), doc)?;
            b.function(&name, "Chooses.", Mux { selector, inputs, output })?;
        }
        Ok(())
    }
}

#[derive(Touch)]
struct Mux {
    selector: Selector,
    inputs: Vec<Source>,
    output: Goal,
}

impl Update for Mux {
    fn update(&mut self, period: Period) {
        let Some(chosen) = self.selector.chosen(period) else { return };
        if let Some(input) = self.inputs.get(chosen).or(self.inputs.last()) {
            self.output.follow(input);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::MuxGeneric;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn numbers_and_bits_choose() {
        let rows = replay::<MuxGeneric>(
            "load mux_generic config=ff4
             set mux-gen.00.in-float-00 1.5
             set mux-gen.00.in-float-01 2.5
             set mux-gen.00.in-float-02 -3.5
             set mux-gen.00.in-float-03 1e10
             run mux-gen.00
             in mux-gen.00.sel-int mux-gen.00.sel-bit-00 mux-gen.00.sel-bit-01
             out mux-gen.00.out-float mux-gen.00.selected
             0 0 0 | 1.5 0
             1 0 0 | 2.5 1
             3 0 0 | 1e10 3
             4 0 0 | 1e10 4
             1 0 1 | 1e10 3
             0 1 0 | 2.5 1
             4294967295 0 0 | 1e10 4294967295
             4294967295 1 0 | 1.5 0
             set mux-gen.00.suppress-no-input 1
             2 0 0 | -3.5 2
             0 0 0 | -3.5 2",
        );
        assert_eq!(rows, 10);
    }

    #[test]
    fn what_changes_must_stay() {
        let rows = replay::<MuxGeneric>(
            "load mux_generic config=ss3
             set mux-gen.00.in-s32-01 11
             set mux-gen.00.in-s32-02 22
             set mux-gen.00.debounce-us 2000
             run mux-gen.00
             in mux-gen.00.sel-int
             out mux-gen.00.out-s32 mux-gen.00.elapsed
             1 | 0 1000
             1 | 0 2000
             2 | 22 0
             0 | 22 1000
             2 | 22 0
             1 | 22 1000
             0 | 22 2000
             1 | 11 0",
        );
        assert_eq!(rows, 8);
    }

    #[test]
    fn every_type_becomes_every_other() {
        for (config, input, rows) in [
            ("fb2", "float", "2e-7 | 0\n2.1e-7 | 1\n-5 | 1\nnan | 0\ninf | 1"),
            (
                "fs2",
                "float",
                "2147483647.5 | 2147483647\n-2147483648.9 | -2147483647\nnan | -2147483648\n-0.9 | 0",
            ),
            ("fu2", "float", "4294967296 | 4294967295\n-1 | 0\nnan | 0\n7.9 | 7"),
            ("su2", "s32", "-1 | 0\n5 | 5"),
            ("us2", "u32", "4294967295 | 2147483647\n5 | 5"),
            ("uf2", "u32", "4294967295 | 4294967295"),
            ("sf2", "s32", "-5 | -5"),
            ("sb2", "s32", "-5 | 1\n0 | 0"),
            ("ub2", "u32", "256 | 1\n0 | 0"),
            ("bf2", "bit", "1 | 1\n0 | 0"),
            ("bs2", "bit", "1 | 1"),
            ("bu2", "bit", "1 | 1"),
            ("bb2", "bit", "1 | 1"),
        ] {
            let to = match config.as_bytes()[1] {
                b'b' => "bit",
                b'f' => "float",
                b's' => "s32",
                _ => "u32",
            };
            replay::<MuxGeneric>(&format!(
                "load mux_generic config={config}\nrun mux-gen.00\nin mux-gen.00.in-{input}-00\n\
                 out mux-gen.00.out-{to}\n{rows}"
            ));
        }
    }

    #[test]
    fn a_wrong_config_makes_nothing() {
        let mut bench = Bench::new();
        let said = bench.load::<MuxGeneric>(&["config=ff4,fx4"]).unwrap_err();
        assert!(said.starts_with("config=fx4: 'x' is not a type"), "{said}");
        assert!(bench.names().is_empty());
    }
}
