//! `bldc`.
use crate::{
    commutate::ALIGN,
    drive::Outputs,
    letters::{Feedback, Letters},
};
use hal_component::{
    Arg, Builder, Component, Error, In, Io, Messages, Out, ParamRo, ParamRw, Touch,
    abi::{ArgSpec, component_flags},
};

/// Maximum number of motors.
const MAX: u32 = 8;

/// Commutation of three-phase motors.
pub(crate) struct Bldc;

impl Component for Bldc {
    const NAME: &'static str = "bldc";
    const DOC: &'static str = include_str!("bldc.md");
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::texts(
            "cfg",
            "For each motor the letters of its feedback (n h a q i f) and of its drive (B 6 H F T), such as hH.",
        )
        .required()
        .at_most(MAX),
        &Arg::ints("personality", "Accepted for compatibility and ignored: cfg= counts."),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let texts = b.arg_texts("cfg");
        let all: Result<Vec<Letters>, _> = texts.iter().map(|t| Letters::read(t)).collect();
        for (i, letters) in all?.into_iter().enumerate() {
            let name = format!("bldc.{i}");
            let motor = Motor::declare(b, &name, letters)?;
            b.function(&name, "Reads the feedback and drives the motor.", motor)?;
        }
        Ok(())
    }
}

#[derive(Touch)]
pub(crate) struct Halls {
    pub(crate) sensors: [In<bool>; 3],
    pub(crate) error: Out<bool>,
    pub(crate) pattern: ParamRw<u32>,
}

#[derive(Touch)]
pub(crate) struct Counter {
    pub(crate) lead_angle: In<f64>,
    pub(crate) rawcounts: In<i32>,
    pub(crate) scale: ParamRw<i32>,
    pub(crate) poles: ParamRw<i32>,
}

#[derive(Touch)]
pub(crate) struct Motor {
    pub(crate) halls: Option<Halls>,
    pub(crate) gray: Option<[In<bool>; 4]>,
    pub(crate) value: In<f64>,
    pub(crate) counter: Option<Counter>,
    pub(crate) rev: In<bool>,
    pub(crate) frequency: Option<In<f64>>,
    pub(crate) initvalue: Option<In<f64>>,
    pub(crate) index_enable: Option<Io<bool>>,
    pub(crate) init: Option<(In<bool>, Out<bool>)>,
    pub(crate) outputs: Outputs,
    pub(crate) phase_angle: Out<f64>,
    pub(crate) rotor_angle: Out<f64>,
    pub(crate) out: Out<f64>,
    pub(crate) out_dir: Out<bool>,
    pub(crate) out_abs: Out<f64>,
    pub(crate) in_type: ParamRo<i32>,
    pub(crate) out_type: ParamRo<i32>,
    pub(crate) encoder_offset: Option<ParamRw<i32>>,
    pub(crate) offset_measured: Option<ParamRo<i32>>,
    pub(crate) drive_offset: ParamRw<f64>,
    pub(crate) messages: Messages,
    #[state]
    pub(crate) letters: Letters,
    #[state]
    pub(crate) state: State,
}

pub(crate) struct State {
    pub(crate) begun: bool,
    pub(crate) feedback: Feedback,
    /// Counts of the last cycle.
    pub(crate) counts: i32,
    /// Sector of the Hall sensors in the last cycle, if there was one, and the pattern it belongs to.
    pub(crate) sector: Option<Option<usize>>,
    pub(crate) pattern: u32,
    pub(crate) init: bool,
    /// Remaining time of the alignment, in seconds.
    pub(crate) left: f64,
}

impl Motor {
    fn declare(b: &mut Builder<'_>, name: &str, letters: Letters) -> Result<Self, Error> {
        let has = |any: &str| letters.any(any);
        let pin = |end: &str| format!("{name}.{end}");
        Ok(Self {
            halls: has("h").then(|| Halls::declare(b, name)).transpose()?,
            gray: has("f").then(|| gray(b, name)).transpose()?,
            value: b.item(&pin("value"), "Commanded drive level, in any unit, such as volts; \
                negative for the reverse direction.", 0.0)?,
            counter: has("aq").then(|| Counter::declare(b, name)).transpose()?,
            rev: b.item(&pin("rev"), "Reverses the direction.", false)?,
            frequency: (!has("haqi"))
                .then(|| b.item(&pin("frequency"), "Electrical turns per second.", 0.0))
                .transpose()?,
            initvalue: has("q")
                .then(|| b.item(&pin("initvalue"), "Drive level during an alignment, in the unit \
                    of value.", 0.2))
                .transpose()?,
            index_enable: has("i")
                .then(|| {
                    let doc = "Asks the encoder for its index, which clears it; goes to the \
                               encoder's index-enable.";
                    b.item(&pin("index-enable"), doc, false)
                })
                .transpose()?,
            init: letters.aligns().then(|| init(b, name)).transpose()?,
            outputs: Outputs::declare(b, name, letters)?,
            phase_angle: b.item(
                &pin("phase-angle"),
                "Commanded angle of the field, in electrical turns from 0 to 1.",
                0.0,
            )?,
            rotor_angle: b.item(
                &pin("rotor-angle"),
                "Angle of the rotor, in electrical turns from 0 to 1.",
                0.0,
            )?,
            out: b.item(&pin("out"), "Drive level, in the unit of value; negative for the reverse \
                direction.", 0.0)?,
            out_dir: b.item(&pin("out-dir"), "True if the drive level is below 0.", false)?,
            out_abs: b.item(&pin("out-abs"), "Magnitude of the drive level, in the unit of \
                value.", 0.0)?,
            in_type: b.item(
                &pin("in-type"),
                "The feedback in use, once it runs: 0 none, 1 Hall, 2 counts, 4 waits for or does an \
                 alignment, 12 the same to the index, 5 Hall until it changes, 13 Hall until the \
                 index, 16 and above Gray code.",
                -1,
            )?,
            out_type: b.item(
                &pin("out-type"),
                "The drive, once it runs: 0 values, 256 bits, 512 six values, 768 six bits, 1024 Hall \
                 codes, 2048 Gray code.",
                -1,
            )?,
            encoder_offset: has("ai")
                .then(|| {
                    let doc = "Counts where the rotor's angle is 0.";
                    b.item(&pin("encoder-offset"), doc, 0)
                })
                .transpose()?,
            offset_measured: has("q")
                .then(|| {
                    let doc = "Counts where the alignment, Hall sensors or index were.";
                    b.item(&pin("offset-measured"), doc, 0)
                })
                .transpose()?,
            drive_offset: b.item(
                &pin("drive-offset"),
                "Angle that the drive adds to the rotor's, in degrees; subtracted during an \
                alignment.",
                0.0,
            )?,
            messages: b.messages(),
            letters,
            state: State {
                begun: false,
                feedback: letters.feedback,
                counts: 0,
                sector: None,
                pattern: 0,
                init: false,
                left: ALIGN,
            },
        })
    }
}

impl Halls {
    fn declare(b: &mut Builder<'_>, name: &str) -> Result<Self, Error> {
        let mut sensor = |i: i32| b.item(&format!("{name}.hall{i}"), "A Hall sensor.", false);
        let sensors = [sensor(1)?, sensor(2)?, sensor(3)?];
        let error = b.item(
            &format!("{name}.hall-error"),
            "True after a sensor state that is not in the pattern, or a skipped step; until the \
            pattern changes.",
            false,
        )?;
        let doc = "Pattern of the Hall sensors, 0 to 47; a higher one becomes 0.";
        Ok(Self { sensors, error, pattern: b.item(&format!("{name}.pattern"), doc, 25)? })
    }

    pub(crate) fn code(&self) -> u8 {
        self.sensors.iter().fold(0, |code, s| code << 1 | u8::from(s.get()))
    }
}

impl Counter {
    fn declare(b: &mut Builder<'_>, name: &str) -> Result<Self, Error> {
        let pin = |end: &str| format!("{name}.{end}");
        Ok(Self {
            lead_angle: b.item(
                &pin("lead-angle"),
                "Lead of the field ahead of the rotor, in electrical degrees.",
                90.0,
            )?,
            rawcounts: b.item(
                &pin("rawcounts"),
                "The encoder's counts; rawcounts, because an index clears the others.",
                0,
            )?,
            scale: b.item(
                &pin("scale"),
                "Counts in a turn of the motor; 0 gives no angle.",
                512,
            )?,
            poles: b.item(
                &pin("poles"),
                "Poles of the motor, two for each electrical turn in a turn.",
                4,
            )?,
        })
    }
}

fn gray(b: &mut Builder<'_>, name: &str) -> Result<[In<bool>; 4], Error> {
    let mut bit = |i: i32| b.item(&format!("{name}.C{i}"), "A bit of the Gray code.", false);
    Ok([bit(1)?, bit(2)?, bit(4)?, bit(8)?])
}

fn init(b: &mut Builder<'_>, name: &str) -> Result<(In<bool>, Out<bool>), Error> {
    let doc = "Starts the alignment when it becomes true, and continues while it is true.";
    let begin = b.item(&format!("{name}.init"), doc, false)?;
    let done = b.item(&format!("{name}.init-done"), "True when the motor is aligned.", false)?;
    Ok((begin, done))
}

#[cfg(test)]
mod tests {
    use super::Bldc;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert!(replay::<Bldc>(include_str!("../traces/bldc.txt")) > 500);
    }

    #[test]
    fn a_frequency_that_was_none_is_forgotten() {
        let mut bench = Bench::new();
        bench.load::<Bldc>(&["cfg=n"]).unwrap();
        for (frequency, finite) in [(5.0, true), (f64::NAN, false), (5.0, true)] {
            bench.set("bldc.0.frequency", frequency);
            bench.run("bldc.0", 1_000_000);
            assert_eq!(bench.get::<f64>("bldc.0.rotor-angle").is_finite(), finite, "{frequency}");
        }
    }

    #[test]
    fn counts_and_poles_at_their_ends_are_no_panic() {
        for cfg in ["a", "aB6"] {
            let mut bench = Bench::new();
            bench.load::<Bldc>(&[&format!("cfg={cfg}")]).unwrap();
            for (counts, poles) in [(0, 2), (i32::MIN, i32::MAX), (i32::MAX, i32::MIN)] {
                bench.set("bldc.0.rawcounts", counts);
                bench.set("bldc.0.encoder-offset", !counts);
                bench.set("bldc.0.poles", poles);
                bench.run("bldc.0", 1_000_000);
                let angle = bench.get::<f64>("bldc.0.rotor-angle");
                assert!((0.0..=1.0).contains(&angle), "{cfg} {poles}: {angle}");
            }
        }
    }

    /// Returns a bench with one motor, `cfg` and settings, after its first cycle.
    fn motor(cfg: &str, settings: &[(&str, f64)]) -> Bench {
        let mut bench = Bench::new();
        bench.load::<Bldc>(&[&format!("cfg={cfg}")]).unwrap();
        for (pin, value) in settings {
            bench.set(&format!("bldc.0.{pin}"), *value);
        }
        bench.run("bldc.0", 1_000_000);
        bench
    }

    /// The motor is pulled to zero in 2.4 s; the encoder's count there becomes the zero.
    #[test]
    fn aligns() {
        let b = motor("q", &[("value", 0.5)]);
        b.set("bldc.0.rawcounts", 20);
        b.set("bldc.0.init", true);
        let mut last = 0.0;
        for cycle in 0..2401 {
            b.run("bldc.0", 1_000_000);
            assert_eq!(b.get::<i32>("bldc.0.in-type"), 4, "{cycle}");
            let phase = b.get::<f64>("bldc.0.phase-angle");
            let step = (phase - last + 1.5) % 1.0 - 0.5;
            assert!(step.abs() < 0.002, "{cycle}");
            last = phase;
            let ramp = (f64::from(cycle) / 400.0).min(1.0) * 0.2;
            assert!((b.get::<f64>("bldc.0.out") - ramp).abs() < 1e-12, "{cycle}");
        }
        assert_eq!(last, 0.0);
        b.run("bldc.0", 1_000_000);
        assert!(b.get::<bool>("bldc.0.init-done"));
        assert_eq!(b.get::<i32>("bldc.0.offset-measured"), 20);
        // After a quarter of an electrical turn, the field is a quarter ahead.
        b.set("bldc.0.rawcounts", 84);
        b.run("bldc.0", 1_000_000);
        b.run("bldc.0", 1_000_000);
        assert_eq!(b.get::<f64>("bldc.0.rotor-angle"), 0.25);
        assert_eq!(b.get::<f64>("bldc.0.phase-angle"), 0.5);
        // A second request restarts the alignment.
        b.set("bldc.0.init", false);
        b.run("bldc.0", 1_000_000);
        b.set("bldc.0.init", true);
        b.run("bldc.0", 1_000_000);
        assert_eq!(b.get::<i32>("bldc.0.in-type"), 4);
        assert!(!b.get::<bool>("bldc.0.init-done"));
    }

    #[test]
    fn turns_to_the_index() {
        let b = motor("qi", &[("initvalue", 0.25)]);
        assert!(b.get::<bool>("bldc.0.index-enable"));
        b.set("bldc.0.init", true);
        for _ in 0..100 {
            b.run("bldc.0", 1_000_000);
        }
        assert!((b.get::<f64>("bldc.0.phase-angle") - 0.1).abs() < 1e-12);
        assert_eq!(b.get::<f64>("bldc.0.out-abs"), 0.25);
        b.set("bldc.0.index-enable", false);
        b.set("bldc.0.rawcounts", 7);
        b.run("bldc.0", 1_000_000);
        assert_eq!(b.get::<i32>("bldc.0.in-type"), 2);
        assert_eq!(b.get::<i32>("bldc.0.offset-measured"), 7);
    }

    /// The index search restarts from zero if counts gave no valid angle.
    #[test]
    fn turns_from_no_angle() {
        let b = motor("qi", &[("initvalue", 0.25)]);
        b.set("bldc.0.init", true);
        b.run("bldc.0", 1_000_000);
        b.set("bldc.0.index-enable", false);
        b.set("bldc.0.scale", 0);
        b.run("bldc.0", 1_000_000);
        b.run("bldc.0", 1_000_000);
        assert!(b.get::<f64>("bldc.0.rotor-angle").is_nan());
        b.set("bldc.0.init", false);
        b.run("bldc.0", 1_000_000);
        b.set("bldc.0.init", true);
        b.set("bldc.0.index-enable", true);
        b.run("bldc.0", 1_000_000);
        b.run("bldc.0", 1_000_000);
        assert!(b.get::<f64>("bldc.0.rotor-angle").is_finite());
    }

    /// A rotor without feedback gives the drive three sines whose sum is zero.
    #[test]
    fn sines_are_balanced() {
        let b = motor("n,n6", &[("value", 2.0), ("frequency", 7.0)]);
        b.set("bldc.1.value", 2.0);
        b.set("bldc.1.frequency", 7.0);
        for cycle in 1..500 {
            b.run("bldc.0", 1_000_000);
            b.run("bldc.1", 1_000_000);
            let [a, b2, c] = ["A", "B", "C"].map(|p| b.get::<f64>(&format!("bldc.0.{p}-value")));
            let turn = f64::from(cycle) * 0.007 * std::f64::consts::TAU;
            assert!((a - 2.0 * libm::cos(turn)).abs() < 1e-9);
            assert!((a + b2 + c).abs() < 1e-12);
            assert!((a * a + b2 * b2 + c * c - 6.0).abs() < 1e-12);
            if cycle > 1 {
                for (p, v) in [("A", a), ("B", b2), ("C", c)] {
                    let high = b.get::<f64>(&format!("bldc.1.{p}-high"));
                    let low = b.get::<f64>(&format!("bldc.1.{p}-low"));
                    assert!(high.min(low) == 0.0 && high >= 0.0 && low >= 0.0 && v.is_finite());
                }
            }
        }
    }

    #[test]
    fn edges() {
        let b = motor("a,nB6,h", &[("value", 1.0)]);
        b.set("bldc.0.scale", 0);
        b.run("bldc.0", 1_000_000);
        assert!(b.get::<f64>("bldc.0.rotor-angle").is_nan());
        // An angle that is not finite drives no phase.
        b.set("bldc.1.value", 1.0);
        b.set("bldc.1.frequency", f64::INFINITY);
        b.run("bldc.1", 1_000_000);
        b.run("bldc.1", 1_000_000);
        for pin in ["A-high-on", "B-high-on", "C-high-on", "A-low-on", "B-low-on", "C-low-on"] {
            assert!(!b.get::<bool>(&format!("bldc.1.{pin}")), "{pin}");
        }
        b.set("bldc.2.pattern", 48_u32);
        b.run("bldc.2", 1_000_000);
        b.run("bldc.2", 1_000_000);
        assert_eq!(b.get::<u32>("bldc.2.pattern"), 0);
    }

    #[test]
    fn refusals_make_nothing() {
        for (cfg, why) in [("h,qx", "'x' is no letter"), ("h,i", "i needs q")] {
            let mut bench = Bench::new();
            let said = bench.load::<Bldc>(&[&format!("cfg={cfg}")]).unwrap_err();
            assert!(said.contains(why), "{said}");
            assert!(bench.names().is_empty(), "{cfg}");
        }
    }
}
