//! `debounce`.
use hal_component::{
    Arg, Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Groups of debounce filters.
pub(crate) struct Debounce;

impl Component for Debounce {
    const NAME: &'static str = "debounce";
    const DOC: &'static str = "Filters for switches that bounce, in groups.\n\n\
        `cfg=4,2` makes a group of four filters, `debounce.0.0.in` and `.out` to `debounce.0.3`, \
        and a group of two. Each group has a function, `debounce.0`, and a delay. A filter counts \
        up at each run with its input true and down at each run with it false; its output changes \
        when the count would leave its range, from zero to the delay.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt debounce cfg=2\n\
        loadrt threads name1=servo period1=1000000\n\
        addf debounce.0 servo\n\
        start\n\
        setp debounce.0.1.in 1\n\
        run 3ms\n\
        getp debounce.0.1.out # -> FALSE\n\
        run 3ms\n\
        getp debounce.0.1.out # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::ints(
        "cfg",
        "Number of filters in each group; a zero ends the list. At most 8 groups.",
    )
    .within(0.0, 50.0)
    .at_most(8)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let sizes: Vec<i64> = b.arg_ints("cfg").into_iter().take_while(|n| *n != 0).collect();
        if sizes.is_empty() {
            return Err(Error::new("DEBOUNCE: ERROR: no channels configured"));
        }
        for (g, size) in sizes.iter().enumerate() {
            let delay = b.item(
                &format!("debounce.{g}.delay"),
                "Number of runs after the first for which an input must hold before its output \
                follows; a negative number counts as 1.",
                5,
            )?;
            let mut filters = Vec::new();
            for i in 0..*size {
                filters.push(Filter {
                    from: b.item(&format!("debounce.{g}.{i}.in"), "The bouncing bit.", false)?,
                    to: b.item(&format!("debounce.{g}.{i}.out"), "The steady bit.", false)?,
                    count: 0,
                });
            }
            let group = Group { delay, filters };
            b.function(&format!("debounce.{g}"), "Runs the filters of the group.", group)?;
        }
        Ok(())
    }
}

#[derive(Touch)]
struct Filter {
    from: In<bool>,
    to: Out<bool>,
    #[state]
    count: i32,
}

#[derive(Touch)]
struct Group {
    delay: ParamRw<i32>,
    filters: Vec<Filter>,
}

impl Update for Group {
    fn update(&mut self, _: Period) {
        if self.delay.get() < 0 {
            self.delay.set(1);
        }
        let delay = self.delay.get();
        for f in &mut self.filters {
            if f.from.get() {
                if f.count < delay {
                    f.count += 1;
                } else {
                    f.to.set(true);
                }
            } else if f.count > 0 {
                f.count -= 1;
            } else {
                f.to.set(false);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Debounce;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Debounce>(include_str!("../traces/debounce.txt")), 360);
    }

    #[test]
    fn groups() {
        let mut bench = Bench::new();
        bench.load::<Debounce>(&["cfg=1,2,0,3"]).unwrap();
        assert_eq!(
            bench.names(),
            [
                "debounce.0.0.in bit IN",
                "debounce.0.0.out bit OUT",
                "debounce.0.delay s32 RW",
                "debounce.1.0.in bit IN",
                "debounce.1.0.out bit OUT",
                "debounce.1.1.in bit IN",
                "debounce.1.1.out bit OUT",
                "debounce.1.delay s32 RW"
            ]
        );
        assert_eq!(bench.functs(), ["debounce.0", "debounce.1"]);
    }

    #[test]
    fn refusals() {
        for (cfg, wanted) in [
            ("cfg=0", "DEBOUNCE: ERROR: no channels configured"),
            ("cfg=2,-1", "`-1' out of range for parameter `cfg=2,-1'"),
            ("cfg=51", "`51' out of range for parameter `cfg=51'"),
        ] {
            let mut bench = Bench::new();
            assert_eq!(bench.load::<Debounce>(&[cfg]).unwrap_err(), wanted);
            assert!(bench.names().is_empty());
        }
        let nothing = Bench::new().load::<Debounce>(&[]).unwrap_err();
        assert_eq!(nothing, "DEBOUNCE: ERROR: no channels configured");
    }
}
