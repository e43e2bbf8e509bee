//! `charge_pump`.
use hal_component::{
    Builder, Component, Decl, Error, In, Out, Period, Touch, Update,
    abi::{ItemSpec, component_flags},
};

const ENABLE: Decl<'static> =
    Decl::new("charge-pump.enable", "While false, the outputs are false.");
const OUT: Decl<'static> = Decl::new("charge-pump.out", "Changes at every run while enabled.");
const OUT_2: Decl<'static> = Decl::new("charge-pump.out-2", "Half the frequency of `out`.");
const OUT_4: Decl<'static> = Decl::new("charge-pump.out-4", "A quarter of the frequency of `out`.");

/// Counter whose lowest bits are outputs.
#[derive(Touch)]
pub(crate) struct ChargePump {
    enable: In<bool>,
    outs: [Out<bool>; 3],
    #[state]
    count: u8,
}

impl Component for ChargePump {
    const NAME: &'static str = "charge_pump";
    const DOC: &'static str = "Square wave that stops when the machine stops.\n\n\
        An external charge pump keeps a relay closed only while it gets this square wave: link \
        `out` to a port's pin and put the function `charge-pump` in the thread that must not \
        stop. There is only one instance, without a number in its names.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt charge_pump\n\
        loadrt threads name1=servo period1=1000000\n\
        addf charge-pump servo\n\
        start\n\
        run 1ms\n\
        getp charge-pump.out # -> TRUE\n\
        run 1ms\n\
        getp charge-pump.out # -> FALSE\n\
        setp charge-pump.enable 0\n\
        run 5ms\n\
        getp charge-pump.out # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ITEMS: &'static [&'static ItemSpec] = &[
        &ENABLE.spec::<In<bool>>(1),
        &OUT.spec::<Out<bool>>(0),
        &OUT_2.spec::<Out<bool>>(0),
        &OUT_4.spec::<Out<bool>>(0),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let pump = Self {
            enable: b.declare(ENABLE, true)?,
            outs: [b.declare(OUT, false)?, b.declare(OUT_2, false)?, b.declare(OUT_4, false)?],
            count: 0,
        };
        b.function("charge-pump", "Counts, and writes the outputs.", pump)
    }
}

impl Update for ChargePump {
    fn update(&mut self, _: Period) {
        let enabled = self.enable.get();
        if enabled {
            self.count = self.count.wrapping_add(1);
        }
        for (bit, out) in self.outs.iter().enumerate() {
            out.set(enabled && (self.count >> bit) & 1 != 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ChargePump;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<ChargePump>(include_str!("../traces/charge_pump.txt")), 60);
    }

    #[test]
    fn its_names_have_no_number() {
        let mut bench = Bench::new();
        bench.load::<ChargePump>(&[]).unwrap();
        assert_eq!(
            bench.names(),
            [
                "charge-pump.enable bit IN",
                "charge-pump.out bit OUT",
                "charge-pump.out-2 bit OUT",
                "charge-pump.out-4 bit OUT"
            ]
        );
        assert_eq!(bench.functs(), ["charge-pump"]);
    }

    #[test]
    fn the_count_wraps() {
        let mut bench = Bench::new();
        bench.load::<ChargePump>(&[]).unwrap();
        for run in 1..=600 {
            bench.run("charge-pump", 1_000_000);
            assert_eq!(bench.get::<bool>("charge-pump.out"), run & 1 != 0, "{run}");
            assert_eq!(bench.get::<bool>("charge-pump.out-2"), run & 2 != 0, "{run}");
            assert_eq!(bench.get::<bool>("charge-pump.out-4"), run & 4 != 0, "{run}");
        }
    }
}
