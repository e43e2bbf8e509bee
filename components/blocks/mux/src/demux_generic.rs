//! `demux_generic`.
use crate::{
    config::{Config, read},
    kind::{Goal, Source},
    selector::Selector,
};
use hal_component::{
    Arg, Builder, Component, Error, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Demultiplexers of any size and type.
pub(crate) struct DemuxGeneric;

impl Component for DemuxGeneric {
    const NAME: &'static str = "demux_generic";
    const DOC: &'static str = "Passes a value to one of several outputs, of any type; the others \
        are 0.\n\n\
        `config=ff4,bu12` makes `demux-gen.00`, a float to one of four floats, and `demux-gen.01`, a \
        bit to one of twelve unsigned numbers. The letters are `b` bit, `f` float, `s` s32, `u` u32; \
        one alone stands for both. Each has 2 to 1024 outputs. Selector bits exist if the number \
        of outputs is a power of two, or one more; `sel-int` is added to them.\n\n\
        A value out of an output's range becomes the nearest one, as in `mux_generic`.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt demux_generic config=ff4\n\
        loadrt threads name1=servo period1=1000000\n\
        addf demux-gen.00 servo\n\
        start\n\
        setp demux-gen.00.in-float 0.5\n\
        setp demux-gen.00.sel-bit-01 1\n\
        run 1ms\n\
        getp demux-gen.00.out-float-02 # -> 0.5\n\
        setp demux-gen.00.sel-int 1\n\
        run 1ms\n\
        getp demux-gen.00.out-float-02 # -> 0\n\
        getp demux-gen.00.out-float-03 # -> 0.5\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::texts(
        "config",
        "For each instance: the letters of its types, and the number of outputs, such as ff4.",
    )
    .required()
    .at_most(100)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let texts = b.arg_texts("config");
        let list: Result<Vec<Config>, _> = texts.iter().map(String::as_str).map(read).collect();
        for (i, Config { from, to, size }) in list?.into_iter().enumerate() {
            let name = format!("demux-gen.{i:02}");
            let selector = Selector::declare(b, &name, size)?;
            let input =
                from.input(b, &format!("{name}.in-{}", from.word()), "The value, in any unit.")?;
            let mut outputs = Vec::new();
            for i in 0..size {
                let pin = format!("{name}.out-{}-{i:02}", to.word());
                outputs.push(to.output(
                    b,
                    &pin,
                    "The value while this output is selected, in its unit; otherwise 0.",
                )?);
            }
            b.function(&name, "Chooses.", Demux { selector, input, outputs })?;
        }
        Ok(())
    }
}

#[derive(Touch)]
struct Demux {
    selector: Selector,
    input: Source,
    outputs: Vec<Goal>,
}

impl Update for Demux {
    fn update(&mut self, period: Period) {
        let Some(chosen) = self.selector.chosen(period) else { return };
        let chosen = chosen.min(self.outputs.len().saturating_sub(1));
        for (i, out) in self.outputs.iter().enumerate() {
            if i == chosen {
                out.follow(&self.input);
            } else {
                out.clear();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::DemuxGeneric;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn one_has_the_value_and_the_others_nothing() {
        let rows = replay::<DemuxGeneric>(
            "load demux_generic config=fs3
             run demux-gen.00
             in demux-gen.00.in-float demux-gen.00.sel-int
             out demux-gen.00.out-s32-00 demux-gen.00.out-s32-01 demux-gen.00.out-s32-02
             2.9 0 | 2 0 0
             2.9 1 | 0 2 0
             -7 2 | 0 0 -7
             -7 9 | 0 0 -7
             set demux-gen.00.suppress-no-input 1
             1 0 | 0 0 -7
             set demux-gen.00.debounce-us 1000
             1 1 | 0 0 -7
             1 1 | 0 1 0",
        );
        assert_eq!(rows, 7);
    }

    #[test]
    fn pins_as_the_catalogue_has_them() {
        let mut bench = Bench::new();
        bench.load::<DemuxGeneric>(&["config=ff4,bu3"]).unwrap();
        let names = bench.names();
        for pin in [
            "demux-gen.00.sel-bit-01 bit IN",
            "demux-gen.01.out-u32-02 u32 OUT",
            "demux-gen.01.in-bit bit IN",
            "demux-gen.01.elapsed u32 RO",
        ] {
            assert!(names.iter().any(|n| n == pin), "{pin}: {names:?}");
        }
        assert_eq!(names.len(), 22);
        assert_eq!(bench.functs(), ["demux-gen.00", "demux-gen.01"]);
    }
}
