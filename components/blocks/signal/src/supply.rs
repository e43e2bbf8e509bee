//! `supply`.
use hal_component::{
    Arg, Builder, Component, Error, Io, Out, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Source of values for tests.
#[derive(Touch)]
pub(crate) struct Supply {
    q: Out<bool>,
    not_q: Out<bool>,
    variable: Out<f64>,
    negative: Out<f64>,
    d: Io<bool>,
    value: Io<f64>,
}

impl Component for Supply {
    const NAME: &'static str = "supply";
    const DOC: &'static str = "A bit and a number set by hand, for experiments.\n\n\
        `num_chan=2` makes `supply.0` and `supply.1`; without it there is one. `setp` and `sets` \
        do the same without this component.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt supply\n\
        loadrt threads name1=servo period1=1000000\n\
        addf supply.0.update servo\n\
        net level supply.0.variable\n\
        start\n\
        setp supply.0.value 1.5\n\
        setp supply.0.d 1\n\
        run 1ms\n\
        gets level # -> 1.5\n\
        getp supply.0._variable # -> -1.5\n\
        getp supply.0._q # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::int("num_chan", "Number of channels.").within(1.0, 8.0).or("1")];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.arg_int("num_chan").unwrap_or(1);
        for i in 0..n {
            let pin = |pin: &str| format!("supply.{i}.{pin}");
            let run = Self {
                q: b.item(&pin("q"), "The bit.", false)?,
                not_q: b.item(&pin("_q"), "The opposite of the bit.", true)?,
                variable: b.item(&pin("variable"), "The number, in any unit.", 0.0)?,
                negative: b.item(
                    &pin("_variable"),
                    "The number, with the other sign, in the same unit.",
                    0.0,
                )?,
                d: b.item(&pin("d"), "Value of `q`.", false)?,
                value: b.item(&pin("value"), "Value of `variable`, in any unit.", 0.0)?,
            };
            b.function(&pin("update"), "Sets the outputs.", run)?;
        }
        Ok(())
    }
}

impl Update for Supply {
    fn update(&mut self, _: Period) {
        let (d, value) = (self.d.get(), self.value.get());
        self.q.set(d);
        self.not_q.set(!d);
        self.variable.set(value);
        self.negative.set(-value);
    }
}

#[cfg(test)]
mod tests {
    use super::Supply;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn both_and_their_opposites() {
        let rows = replay::<Supply>(
            "load supply num_chan=2
             run supply.1.update
             in supply.1.d supply.1.value
             out supply.1.q supply.1._q supply.1.variable supply.1._variable
             0 0 | 0 1 0 0
             1 2.5 | 1 0 2.5 -2.5
             . -inf | 1 0 -inf inf",
        );
        assert_eq!(rows, 3);
    }

    #[test]
    fn one_to_eight() {
        let mut bench = Bench::new();
        bench.load::<Supply>(&[]).unwrap();
        assert_eq!(bench.functs(), ["supply.0.update"]);
        for wrong in ["num_chan=0", "num_chan=9"] {
            let said = Bench::new().load::<Supply>(&[wrong]).unwrap_err();
            assert!(said.contains("out of range for parameter `num_chan="), "{said}");
        }
    }
}
