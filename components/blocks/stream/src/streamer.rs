//! `streamer`.
use crate::channel::{ARGS, AnyOut, Channel, Type, channels};
use hal_component::{
    Builder, Component, Error, In, Io, Out, Period, StreamIn, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Player of records that a program writes.
pub(crate) struct Streamer;

impl Component for Streamer {
    const NAME: &'static str = "streamer";
    const DOC: &'static str = "Plays records that a program wrote to pins, one at a time.\n\n\
        `depth=1000 cfg=fb` makes a channel `streamer.0` with a float pin `pin.0` and a bit pin \
        `pin.1`, and room for 999 records; further channels follow after commas. Its function \
        `streamer.0` writes the next record to the pins. `halstreamer` fills it.\n\n\
        # Example\n\n\
        ```hal\n\
        # Without a writer there is nothing to play.\n\
        loadrt streamer depth=100 cfg=f\n\
        loadrt threads name1=servo period1=1000000\n\
        addf streamer.0 servo\n\
        start\n\
        run 5ms\n\
        getp streamer.0.empty # -> TRUE\n\
        getp streamer.0.underruns # -> 5\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = ARGS;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let list = channels(b, "STREAMER")?;
        list.iter().enumerate().try_for_each(|(n, channel)| Streaming::create(b, n, channel))
    }
}

#[derive(Touch)]
struct Streaming {
    pins: Vec<AnyOut>,
    enable: In<bool>,
    empty: Out<bool>,
    curr_depth: Out<i32>,
    underruns: Io<i32>,
    clock: In<bool>,
    clock_mode: In<i32>,
    ring: StreamIn,
    #[state]
    clock_was: bool,
}

impl Streaming {
    fn create(b: &mut Builder<'_>, n: usize, channel: &Channel) -> Result<(), Error> {
        let name = |pin: &str| format!("streamer.{n}.{pin}");
        let codes: Vec<u8> = channel.types.iter().map(|ty| Type::code(*ty)).collect();
        let ring = b.stream_in(&format!("streamer.{n}"), channel.depth, &codes)?;
        let mut pins = Vec::new();
        for (i, ty) in channel.types.iter().enumerate() {
            let doc = "A value of the last record, in any unit.";
            pins.push(AnyOut::create(b, *ty, &name(&format!("pin.{i}")), doc)?);
        }
        let streaming = Self {
            pins,
            enable: b.item(&name("enable"), "True enables reading of records.", true)?,
            empty: b.item(&name("empty"), "True when no record waited for this run.", true)?,
            curr_depth: b.item(
                &name("curr-depth"),
                "Number of records that waited when this run began.",
                0,
            )?,
            underruns: b.item(
                &name("underruns"),
                "Number of times that no record was available when due; can be reset.",
                0,
            )?,
            clock: b.item(&name("clock"), "Clock, if `clock-mode` requires one.", false)?,
            clock_mode: b.item(
                &name("clock-mode"),
                "Time at which a record is due: 1 falling edge of `clock`, 2 rising edge, 3 both \
                edges, otherwise every run.",
                0,
            )?,
            ring,
            clock_was: false,
        };
        b.function(&format!("streamer.{n}"), "Writes the next record to the pins.", streaming)
    }
}

impl Update for Streaming {
    fn update(&mut self, _: Period) {
        let waiting = self.ring.waiting();
        self.curr_depth.set(i32::try_from(waiting).unwrap_or(i32::MAX));
        self.empty.set(waiting == 0);
        let clock = self.clock.get();
        let was = core::mem::replace(&mut self.clock_was, clock);
        let due = match self.clock_mode.get() {
            1 => was && !clock,
            2 => clock && !was,
            3 => clock != was,
            _ => true,
        };
        if !due || !self.enable.get() {
            return;
        }
        let pins = &self.pins;
        let played = self.ring.take(|i, bits| {
            if let Some(pin) = pins.get(i) {
                pin.set(bits);
            }
        });
        if !played {
            self.underruns.set(self.underruns.get().wrapping_add(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Streamer;
    use hal_bench::Bench;

    /// Inputs and results of a cycle: `enable clock`, then `curr-depth underruns` and the number of records taken so
    /// far.
    type Run = (u8, u8, i32, i32, u8);

    /// Five waiting records of `0.5 + k` for each mode, as measured on LinuxCNC 2.9.
    #[rustfmt::skip]
    const MODES: &[(i32, &[Run])] = &[
        (0, &[(1, 0, 5, 0, 1), (1, 0, 4, 0, 2), (1, 0, 3, 0, 3), (0, 0, 2, 0, 3), (0, 0, 2, 0, 3),
              (1, 0, 2, 0, 4), (1, 0, 1, 0, 5), (1, 0, 0, 1, 5), (1, 0, 0, 2, 5), (1, 0, 0, 3, 5)]),
        (1, &[(1, 0, 5, 0, 0), (1, 1, 5, 0, 0), (1, 1, 5, 0, 0), (1, 0, 5, 0, 1), (1, 0, 4, 0, 1),
              (1, 1, 4, 0, 1), (1, 0, 4, 0, 2), (0, 1, 3, 0, 2), (1, 0, 3, 0, 3), (0, 1, 2, 0, 3),
              (0, 0, 2, 0, 3), (1, 0, 2, 0, 3), (1, 1, 2, 0, 3), (1, 0, 2, 0, 4), (1, 1, 1, 0, 4),
              (1, 0, 1, 0, 5), (1, 1, 0, 0, 5), (1, 0, 0, 1, 5)]),
        (2, &[(1, 1, 5, 0, 1), (1, 1, 4, 0, 1), (1, 0, 4, 0, 1), (1, 0, 4, 0, 1), (1, 1, 4, 0, 2),
              (1, 0, 3, 0, 2), (1, 0, 3, 0, 2), (1, 1, 3, 0, 3), (1, 1, 2, 0, 3), (1, 0, 2, 0, 3),
              (1, 1, 2, 0, 4), (1, 0, 1, 0, 4), (1, 1, 1, 0, 5), (1, 0, 0, 0, 5), (1, 1, 0, 1, 5)]),
        (3, &[(1, 1, 5, 0, 1), (1, 1, 4, 0, 1), (1, 0, 4, 0, 2), (1, 0, 3, 0, 2), (1, 1, 3, 0, 3),
              (1, 0, 2, 0, 4), (1, 0, 1, 0, 4), (1, 1, 1, 0, 5), (1, 1, 0, 0, 5), (1, 0, 0, 1, 5)]),
        (4, &[(1, 1, 5, 0, 1), (1, 1, 4, 0, 2), (1, 0, 3, 0, 3), (1, 0, 2, 0, 4), (1, 1, 1, 0, 5),
              (1, 0, 0, 1, 5)]),
        (-1, &[(1, 1, 5, 0, 1), (1, 1, 4, 0, 2), (1, 0, 3, 0, 3)]),
    ];

    #[test]
    fn modes() {
        for (mode, runs) in MODES {
            let mut bench = Bench::new();
            bench.load::<Streamer>(&["depth=6", "cfg=fb"]).unwrap();
            let mut writer = bench.writer("streamer.0");
            for k in 0_u8..5 {
                let record = [(f64::from(k) + 0.5).to_bits(), u64::from(k % 2)];
                assert!(writer.put(|i| record[i]));
            }
            assert!(!writer.put(|_| 0), "one slot stays free");
            bench.set("streamer.0.clock-mode", *mode);
            for (i, (enable, clock, depth, underruns, taken)) in runs.iter().enumerate() {
                bench.set("streamer.0.enable", *enable != 0);
                bench.set("streamer.0.clock", *clock != 0);
                bench.run("streamer.0", 1_000_000);
                let place = format!("mode {mode}, run {i}");
                assert_eq!(bench.get::<bool>("streamer.0.empty"), *depth == 0, "{place}");
                assert_eq!(bench.get::<i32>("streamer.0.curr-depth"), *depth, "{place}");
                assert_eq!(bench.get::<i32>("streamer.0.underruns"), *underruns, "{place}");
                let last = if *taken == 0 { 0.0 } else { f64::from(*taken) - 0.5 };
                assert_eq!(bench.get::<f64>("streamer.0.pin.0"), last, "{place}");
                assert_eq!(bench.get::<bool>("streamer.0.pin.1"), last > 0.0 && taken % 2 == 0);
            }
        }
    }

    #[test]
    fn every_type() {
        let mut bench = Bench::new();
        bench.load::<Streamer>(&["depth=3", "cfg=rbSuLk"]).unwrap();
        let record =
            [(-2.5_f64).to_bits(), 1, u64::from(0xffff_fff9_u32), 0xffff_ffff, 1 << 63, u64::MAX];
        assert!(bench.writer("streamer.0").put(|i| record[i]));
        bench.run("streamer.0", 1_000_000);
        assert_eq!(bench.get::<f64>("streamer.0.pin.0"), -2.5);
        assert!(bench.get::<bool>("streamer.0.pin.1"));
        assert_eq!(bench.get::<i32>("streamer.0.pin.2"), -7);
        assert_eq!(bench.get::<u32>("streamer.0.pin.3"), u32::MAX);
        assert_eq!(bench.get::<i64>("streamer.0.pin.4"), i64::MIN);
        assert_eq!(bench.get::<u64>("streamer.0.pin.5"), u64::MAX);
    }

    #[test]
    fn pins_and_defaults() {
        let mut bench = Bench::new();
        bench.load::<Streamer>(&["depth=10", "cfg=fbsu"]).unwrap();
        assert_eq!(
            bench.names(),
            [
                "streamer.0.clock bit IN",
                "streamer.0.clock-mode s32 IN",
                "streamer.0.curr-depth s32 OUT",
                "streamer.0.empty bit OUT",
                "streamer.0.enable bit IN",
                "streamer.0.pin.0 float OUT",
                "streamer.0.pin.1 bit OUT",
                "streamer.0.pin.2 s32 OUT",
                "streamer.0.pin.3 u32 OUT",
                "streamer.0.underruns s32 I/O"
            ]
        );
        assert!(bench.get::<bool>("streamer.0.enable"));
        assert!(bench.get::<bool>("streamer.0.empty"));
        assert_eq!(bench.functs(), ["streamer.0"]);
    }
}
