//! `sampler`.
use crate::channel::{ARGS, AnyIn, Channel, Type, channels};
use hal_component::{
    Builder, Component, Error, In, Io, Out, Period, StreamOut, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Sampler of pin values for a program.
pub(crate) struct Sampler;

impl Component for Sampler {
    const NAME: &'static str = "sampler";
    const DOC: &'static str = "Samples pins in every run, for a program to read.\n\n\
        `depth=1000 cfg=fb` makes a channel `sampler.0` with a float pin `pin.0` and a bit pin \
        `pin.1`, and room for 999 records; further channels follow after commas. Its function \
        `sampler.0` copies all pins at the same moment. `halsampler` prints the records.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt sampler depth=100 cfg=fb\n\
        loadrt threads name1=servo period1=1000000\n\
        addf sampler.0 servo\n\
        start\n\
        setp sampler.0.pin.0 1.5\n\
        run 20ms\n\
        getp sampler.0.curr-depth # -> 20\n\
        getp sampler.0.full # -> FALSE\n\
        # Without a reader it fills up, and counts what is lost.\n\
        run 100ms\n\
        getp sampler.0.full # -> TRUE\n\
        getp sampler.0.overruns # -> 21\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = ARGS;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let list = channels(b, "SAMPLER")?;
        list.iter().enumerate().try_for_each(|(n, channel)| Sampling::create(b, n, channel))
    }
}

#[derive(Touch)]
struct Sampling {
    pins: Vec<AnyIn>,
    enable: In<bool>,
    full: Out<bool>,
    curr_depth: Out<i32>,
    overruns: Io<i32>,
    ring: StreamOut,
    #[state]
    depth: i32,
}

impl Sampling {
    fn create(b: &mut Builder<'_>, n: usize, channel: &Channel) -> Result<(), Error> {
        let name = |pin: &str| format!("sampler.{n}.{pin}");
        let codes: Vec<u8> = channel.types.iter().map(|ty| Type::code(*ty)).collect();
        let ring = b.stream_out(&format!("sampler.{n}"), channel.depth, &codes)?;
        let mut pins = Vec::new();
        for (i, ty) in channel.types.iter().enumerate() {
            pins.push(AnyIn::create(
                b,
                *ty,
                &name(&format!("pin.{i}")),
                "Value to sample, in any unit.",
            )?);
        }
        let _: Io<i32> = b.item(&name("sample-num"), "Kept for old scripts; stays as set.", 0)?;
        let sampling = Self {
            pins,
            enable: b.item(&name("enable"), "True enables sampling.", true)?,
            full: b.item(&name("full"), "True when the ring is full, or was full.", false)?,
            curr_depth: b.item(
                &name("curr-depth"),
                "Number of waiting records; the depth after a lost record.",
                0,
            )?,
            overruns: b.item(
                &name("overruns"),
                "Number of records lost because the ring was full; can be reset.",
                0,
            )?,
            ring,
            depth: i32::try_from(channel.depth).unwrap_or(i32::MAX),
        };
        b.function(&format!("sampler.{n}"), "Takes a sample of every pin.", sampling)
    }
}

impl Update for Sampling {
    fn update(&mut self, _: Period) {
        let pins = &self.pins;
        if self.enable.get() && !self.ring.put(|i| pins.get(i).map_or(0, AnyIn::bits)) {
            self.overruns.set(self.overruns.get().wrapping_add(1));
            self.full.set(true);
            self.curr_depth.set(self.depth);
            return;
        }
        self.full.set(!self.enable.get() && self.ring.room() == 0);
        self.curr_depth.set(i32::try_from(self.ring.waiting()).unwrap_or(i32::MAX));
    }
}

#[cfg(test)]
mod tests {
    use super::Sampler;
    use hal_bench::Bench;
    use hal_component::{
        Value,
        abi::{Consumer, Got},
    };

    fn record(reader: &mut Consumer) -> Option<(u64, Vec<u64>)> {
        let mut values = Vec::new();
        match reader.take(|_, bits| values.push(bits)) {
            Got::Sample(number) => Some((number, values)),
            Got::Nothing | Got::Nonsense => None,
        }
    }

    /// As measured on LinuxCNC 2.9: `pin.0 enable | full curr-depth overruns`.
    const FILLING: &[(f64, bool, bool, i32, i32)] = &[
        (1.0, true, false, 1, 0),
        (2.0, true, false, 2, 0),
        (3.0, false, false, 2, 0),
        (4.0, true, false, 3, 0),
        (5.0, true, false, 4, 0),
        (6.0, true, true, 5, 1),
        (7.0, true, true, 5, 2),
        (8.0, false, true, 4, 2),
        (9.0, true, true, 5, 3),
    ];

    #[test]
    fn fills_up() {
        let mut bench = Bench::new();
        bench.load::<Sampler>(&["depth=5", "cfg=f"]).unwrap();
        for (value, enable, full, depth, overruns) in FILLING {
            bench.set("sampler.0.pin.0", *value);
            bench.set("sampler.0.enable", *enable);
            bench.run("sampler.0", 1_000_000);
            assert_eq!(bench.get::<bool>("sampler.0.full"), *full, "{value}");
            assert_eq!(bench.get::<i32>("sampler.0.curr-depth"), *depth, "{value}");
            assert_eq!(bench.get::<i32>("sampler.0.overruns"), *overruns, "{value}");
            assert_eq!(bench.get::<i32>("sampler.0.sample-num"), 0);
        }
        let mut reader = bench.reader("sampler.0");
        for (number, value) in [(1, 1.0), (2, 2.0), (3, 4.0), (4, 5.0)] {
            assert_eq!(record(&mut reader), Some((number, vec![Value::to_bits(value)])));
        }
        assert_eq!(record(&mut reader), None);
        bench.run("sampler.0", 1_000_000);
        assert_eq!(record(&mut reader).map(|r| r.0), Some(8), "the lost ones have numbers too");
        assert!(!bench.get::<bool>("sampler.0.full"));
        assert_eq!(bench.get::<i32>("sampler.0.curr-depth"), 1);
    }

    #[test]
    fn every_type_at_the_same_moment() {
        let mut bench = Bench::new();
        bench.load::<Sampler>(&["depth=10", "cfg=FrBsulk"]).unwrap();
        let names: Vec<_> = bench.names().into_iter().filter(|n| n.contains(".pin.")).collect();
        assert_eq!(
            names,
            [
                "sampler.0.pin.0 float IN",
                "sampler.0.pin.1 float IN",
                "sampler.0.pin.2 bit IN",
                "sampler.0.pin.3 s32 IN",
                "sampler.0.pin.4 u32 IN",
                "sampler.0.pin.5 s64 IN",
                "sampler.0.pin.6 u64 IN"
            ]
        );
        bench.set("sampler.0.pin.0", 1.5);
        bench.set("sampler.0.pin.1", f64::NEG_INFINITY);
        bench.set("sampler.0.pin.2", true);
        bench.set("sampler.0.pin.3", -3);
        bench.set("sampler.0.pin.4", u32::MAX);
        bench.set("sampler.0.pin.5", i64::MIN);
        bench.set("sampler.0.pin.6", u64::MAX);
        bench.run("sampler.0", 1_000_000);
        let bits = [
            1.5_f64.to_bits(),
            f64::NEG_INFINITY.to_bits(),
            1,
            0xffff_fffd,
            0xffff_ffff,
            1 << 63,
            u64::MAX,
        ];
        assert_eq!(record(&mut bench.reader("sampler.0")), Some((1, bits.to_vec())));
    }

    #[test]
    fn overruns_can_be_set_back() {
        let mut bench = Bench::new();
        bench.load::<Sampler>(&["depth=2", "cfg=b"]).unwrap();
        for (before, after) in [(0, 0), (0, 1), (41, 42), (i32::MAX, i32::MIN)] {
            bench.set("sampler.0.overruns", before);
            bench.run("sampler.0", 1_000_000);
            assert_eq!(bench.get::<i32>("sampler.0.overruns"), after);
        }
    }

    #[test]
    fn pins_and_defaults() {
        let mut bench = Bench::new();
        bench.load::<Sampler>(&["depth=10,4", "cfg=f,b"]).unwrap();
        assert_eq!(
            bench.names(),
            [
                "sampler.0.curr-depth s32 OUT",
                "sampler.0.enable bit IN",
                "sampler.0.full bit OUT",
                "sampler.0.overruns s32 I/O",
                "sampler.0.pin.0 float IN",
                "sampler.0.sample-num s32 I/O",
                "sampler.1.curr-depth s32 OUT",
                "sampler.1.enable bit IN",
                "sampler.1.full bit OUT",
                "sampler.1.overruns s32 I/O",
                "sampler.1.pin.0 bit IN",
                "sampler.1.sample-num s32 I/O"
            ]
        );
        assert!(bench.get::<bool>("sampler.1.enable"));
        assert_eq!(bench.functs(), ["sampler.0", "sampler.1"]);
        bench.run("sampler.1", 1_000_000);
        assert_eq!(record(&mut bench.reader("sampler.0")), None);
        assert_eq!(record(&mut bench.reader("sampler.1")), Some((1, vec![0])));
    }
}
