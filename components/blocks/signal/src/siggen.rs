//! `siggen`.
use hal_component::{
    Arg, Builder, Channels, Component, Error, In, InSet, Out, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

const GENERATORS: Channels = Channels { prefix: "siggen", usual: 1 };
#[cfg(test)]
mod closed;

/// Value of π for sine and cosine.
#[expect(clippy::approx_constant, reason = "the figures that users know come from this one")]
const PI: f64 = 3.141_592_7;

/// Signal generator.
pub(crate) struct Siggen;

impl Component for Siggen {
    const NAME: &'static str = "siggen";
    const DOC: &'static str = "Signal generator: square, sawtooth, triangle, sine and cosine.\n\n\
        `num_chan=2` makes `siggen.0` and `siggen.1`, `names=a,b` makes `a` and `b`, nothing makes \
        one. Each has a function `siggen.N.update`. All outputs of a generator have the same \
        frequency; square, sawtooth and triangle move by plus and minus `amplitude` around \
        `offset`.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt siggen\n\
        loadrt threads name1=servo period1=1000000\n\
        addf siggen.0.update servo\n\
        start\n\
        setp siggen.0.frequency 10\n\
        setp siggen.0.amplitude 2\n\
        run 25ms\n\
        getp siggen.0.square # -> -2\n\
        run 50ms\n\
        getp siggen.0.square # -> 2\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::int("num_chan", "Number of generators; 0 is taken as 1.").within(0.0, 16.0),
        &Arg::texts("names", "Names of the generators, instead of `num_chan=`; at most 16.")
            .at_most(16),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        GENERATORS.names(b)?.iter().try_for_each(|name| Generator::create(b, name))
    }
}

#[derive(Touch)]
struct Generator {
    amplitude: In<f64>,
    frequency: InSet<f64>,
    offset: In<f64>,
    reset: In<bool>,
    square: Out<f64>,
    sawtooth: Out<f64>,
    triangle: Out<f64>,
    sine: Out<f64>,
    cosine: Out<f64>,
    clock: Out<bool>,
    /// Position within the cycle, from 0 to 1.
    #[state]
    index: f64,
}

impl Generator {
    fn create(b: &mut Builder<'_>, name: &str) -> Result<(), Error> {
        let pin = |pin: &str| format!("{name}.{pin}");
        let generator = Self {
            amplitude: b.item(
                &pin("amplitude"),
                "Half the height of the signals, in any unit.",
                1.0,
            )?,
            frequency: b.item(
                &pin("frequency"),
                "Frequency, in hertz; set back to half of the thread's when it is above that.",
                1.0,
            )?,
            offset: b.item(
                &pin("offset"),
                "The middle of the signals, in the unit of `amplitude`.",
                0.0,
            )?,
            reset: b.item(
                &pin("reset"),
                "While true, the signals stay in the middle of their cycle.",
                false,
            )?,
            square: b.item(
                &pin("square"),
                "High in the second half of the cycle, in the unit of `amplitude`.",
                0.0,
            )?,
            sawtooth: b.item(
                &pin("sawtooth"),
                "Rises over the whole cycle, in the unit of `amplitude`.",
                0.0,
            )?,
            triangle: b.item(
                &pin("triangle"),
                "Falls in the first half, then rises, in the unit of `amplitude`.",
                0.0,
            )?,
            sine: b.item(&pin("sine"), "Sine, in the unit of `amplitude`.", 0.0)?,
            cosine: b.item(&pin("cosine"), "Cosine, in the unit of `amplitude`.", 0.0)?,
            clock: b.item(&pin("clock"), "True in the second half of the cycle.", false)?,
            index: 0.0,
        };
        b.function(&pin("update"), "Moves on in the cycle, and writes the signals.", generator)
    }
}

impl Update for Generator {
    fn update(&mut self, period: Period) {
        let dt = period.secs();
        let mut step = self.frequency.get() * dt;
        if step > 0.5 {
            self.frequency.set(0.5 / dt);
            step = 0.5;
        }
        if self.reset.get() {
            self.index = 0.5;
        } else {
            self.index += step;
            if self.index >= 1.0 {
                self.index -= 1.0;
            }
        }
        let second_half = self.index > 0.5;
        let sign = if second_half { 1.0 } else { -1.0 };
        let saw = 2.0 * self.index - 1.0;
        let triangle = 2.0 * saw * sign - 1.0;
        let angle = self.index * (2.0 * PI);
        let (amplitude, offset) = (self.amplitude.get(), self.offset.get());
        self.clock.set(second_half);
        self.square.set(sign * amplitude + offset);
        self.sawtooth.set(saw * amplitude + offset);
        self.triangle.set(triangle * amplitude + offset);
        self.sine.set(libm::sin(angle) * amplitude + offset);
        self.cosine.set(libm::cos(angle) * amplitude + offset);
    }
}

#[cfg(test)]
mod tests {
    use super::Siggen;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Siggen>(include_str!("../traces/siggen.txt")), 414);
    }

    #[test]
    fn names_and_numbers() {
        for (args, wanted) in [
            (&[][..], Ok(vec!["siggen.0.update"])),
            (&["num_chan=0"], Ok(vec!["siggen.0.update"])),
            (&["num_chan=2"], Ok(vec!["siggen.0.update", "siggen.1.update"])),
            (&["names=a,b"], Ok(vec!["a.update", "b.update"])),
            (&["names=a,,b"], Ok(vec!["a.update"])),
            (&["num_chan=17"], Err("`17' out of range for parameter `num_chan=17'")),
            (&["num_chan=-1"], Err("`-1' out of range for parameter `num_chan=-1'")),
            (&["num_chan=1", "names=a"], Err("num_chan= and names= are mutually exclusive")),
        ] {
            let mut bench = Bench::new();
            let made = bench.load::<Siggen>(args).map(|()| bench.functs());
            let wanted = wanted.map(|list| list.into_iter().map(str::to_owned).collect());
            assert_eq!(made, wanted.map_err(str::to_owned), "{args:?}");
        }
        let mut bench = Bench::new();
        bench.load::<Siggen>(&["num_chan=16"]).unwrap();
        assert_eq!(bench.functs().len(), 16);
    }

    #[test]
    fn pins_of_a_generator() {
        let mut bench = Bench::new();
        bench.load::<Siggen>(&["names=x"]).unwrap();
        assert_eq!(
            bench.names(),
            [
                "x.amplitude float IN",
                "x.clock bit OUT",
                "x.cosine float OUT",
                "x.frequency float IN",
                "x.offset float IN",
                "x.reset bit IN",
                "x.sawtooth float OUT",
                "x.sine float OUT",
                "x.square float OUT",
                "x.triangle float OUT"
            ]
        );
        assert_eq!(bench.get::<f64>("x.amplitude"), 1.0);
        assert_eq!(bench.get::<f64>("x.frequency"), 1.0);
    }

    #[test]
    fn generators_are_apart() {
        let mut bench = Bench::new();
        bench.load::<Siggen>(&["num_chan=2"]).unwrap();
        bench.set("siggen.1.frequency", 250.0);
        for name in ["siggen.0.update", "siggen.1.update"] {
            bench.run(name, 1_000_000);
        }
        assert_eq!(bench.get::<f64>("siggen.0.sawtooth"), -0.998);
        assert_eq!(bench.get::<f64>("siggen.1.sawtooth"), -0.5);
    }
}
