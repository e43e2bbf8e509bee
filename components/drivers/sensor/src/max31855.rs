//! `max31855`.
use crate::type_k::{self, single};
use hal_component::{
    Builder, Component, Error, In, Messages, Out, Period, Touch, Update, abi::component_flags,
};

/// Maximum number of chips.
const MAX: i64 = 15;
/// Cycles per conversion: the first half reads a word, the second waits for the chip's next one.
const LAST: u32 = 130;
/// Cycle that reads the last bit.
const WHOLE: u32 = 66;
/// Sensitivity of a type K junction at usual temperatures, as the chip assumes it, in mV per °C.
const SLOPE: f64 = 0.041_276;

/// Type K thermocouples with one MAX31855 each, read bit by bit.
#[derive(Touch)]
pub(crate) struct Max31855 {
    cs: Out<bool>,
    clk: Out<bool>,
    sensors: Vec<Sensor>,
    messages: Messages,
    #[state]
    run: u32,
}

/// State of one chip.
#[derive(Touch)]
struct Sensor {
    data: In<bool>,
    celsius: Out<f64>,
    fahrenheit: Out<f64>,
    kelvin: Out<f64>,
    fault: Out<bool>,
    flags: Out<u32>,
    /// Bits of the word read so far.
    #[state]
    word: u32,
    /// Faults that were reported.
    #[state]
    told: u32,
}

impl Component for Max31855 {
    const NAME: &'static str = "max31855";
    const DOC: &'static str = "Thermocouples of type K with a MAX31855 chip each, read bit by bit.\n\n\
        `personality=` is the number of chips, 0 to 15. They share `clk.out` and `cs.out`; \
        each has a data line. A word takes 130 runs: 65 with `cs.out` low, in which the clock rises and falls, \
        and 65 with it high, in which the chips measure. Bits are read in the second run after the clock \
        has fallen, so the function stands before the one that reads the data line from the hardware. \
        What the line is in the first run but one of a word counts as a fault of the first kind: it \
        must still be low then.\n\n\
        The chip takes its thermocouple for a straight line; this turns the temperature into the voltage \
        that was measured, and by the curve of type K into the temperature of the tip, in single \
        precision, to 0.1 °C from -200 to 1372 °C. Above that it is as the chip told it, \
        and below it is worthless. A word with a fault changes no temperature; a message says so when the fault \
        is a new one.\n\n\
        # Example\n\n\
        A line that stays high is a chip with all faults at once.\n\n\
        ```hal\n\
        loadrt max31855 personality=1\n\
        loadrt threads name1=servo period1=1000000\n\
        addf max31855.0.bitbang-spi servo\n\
        start\n\
        run 67ms\n\
        getp max31855.0.temp-kelvin.0 # -> 273.15\n\
        getp max31855.0.fault.0 # -> FALSE\n\
        setp max31855.0.data.0.in 1\n\
        run 130ms\n\
        getp max31855.0.fault-flags.0 # -> 7\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.personality();
        if !(0..=MAX).contains(&n) {
            let text = format!("personality={n} is not a number of chips, 0 to {MAX}");
            return Err(Error::new(text));
        }
        let chips = Self {
            cs: b.item("cs.out", "Selects the chips: low while a word is read.", false)?,
            clk: b.item(
                "clk.out",
                "The clock: the chips go to their next bit as it falls.",
                false,
            )?,
            sensors: (0..n).map(|i| Sensor::declare(b, i)).collect::<Result<_, _>>()?,
            messages: b.messages(),
            run: 0,
        };
        b.function("bitbang-spi", "Half a cycle of the clock.", chips)
    }
}

impl Sensor {
    fn declare(b: &mut Builder<'_>, i: i64) -> Result<Self, Error> {
        Ok(Self {
            data: b.item(&format!("data.{i}.in"), "The chip's data line.", false)?,
            celsius: b.item(&format!("temp-celsius.{i}"), "Temperature of the tip, in °C.", 0.0)?,
            fahrenheit: b.item(
                &format!("temp-fahrenheit.{i}"),
                "Temperature of the tip, in °F.",
                0.0,
            )?,
            kelvin: b.item(&format!("temp-kelvin.{i}"), "Temperature of the tip, in K.", 0.0)?,
            fault: b.item(&format!("fault.{i}"), "True if the last word reported a fault.", false)?,
            flags: b.item(
                &format!("fault-flags.{i}"),
                "The faults of the last word: 1 the thermocouple is open, 2 it touches ground, 4 it touches \
                 the supply, or sums of them.",
                0,
            )?,
            word: 0,
            told: 0,
        })
    }

    /// Computes the temperatures of a complete word: bits 31 to 18 are the thermocouple's in quarters of a degree, bits
    /// 15 to 4 the chip's in sixteenths, and bits 2 to 0 are faults.
    fn read(&self) {
        let faults = self.word & 7;
        self.flags.set(faults);
        self.fault.set(faults != 0);
        if faults != 0 {
            return;
        }
        let tip = (self.word.cast_signed() >> 18) as f32 * 0.25;
        let chip = ((self.word << 16).cast_signed() >> 20) as f32 * 0.0625;
        let measured = single(f64::from(tip - chip) * SLOPE);
        let celsius = type_k::celsius(type_k::millivolts(chip) + measured).unwrap_or(tip);
        let celsius = f64::from(celsius);
        self.celsius.set(celsius);
        self.fahrenheit.set(f64::from(single(celsius * 1.8 + 32.0)));
        self.kelvin.set(f64::from(single(celsius + 273.15)));
    }
}

impl Update for Max31855 {
    fn update(&mut self, _: Period) {
        let run = self.run;
        self.cs.set((WHOLE..=LAST).contains(&run));
        self.clk.set(run & 1 == 0);
        if (2..=WHOLE).contains(&run) && run & 1 == 0 {
            // The first of 33 bits has no place in the word; it is stored at its number modulo 32.
            let place = (WHOLE - run) / 2 % 32;
            for (i, sensor) in self.sensors.iter_mut().enumerate() {
                if run == 2 {
                    sensor.word = 0;
                }
                sensor.word |= u32::from(sensor.data.get()) << place;
                if run == WHOLE {
                    sensor.read();
                    let faults = sensor.flags.get();
                    if faults != sensor.told && faults != 0 {
                        let text = "max31855: sensor {} detected fault {}";
                        self.messages.error(text, &[i as f64, f64::from(faults)]);
                    }
                    sensor.told = faults;
                }
            }
        }
        self.run = if run == LAST { 1 } else { run + 1 };
    }
}

#[cfg(test)]
mod tests {
    use super::Max31855;
    use hal_bench::Bench;

    /// Simulated chip: outputs its word on a line, the highest bit when selected, the next at each falling clock edge;
    /// the line is low while the chip is not selected.
    struct Chip {
        word: u32,
        left: u32,
        selected: bool,
        clock: bool,
    }

    impl Chip {
        fn new(word: u32) -> Self {
            Self { word, left: 0, selected: false, clock: false }
        }

        fn sees(&mut self, selected: bool, clock: bool) {
            if selected && !self.selected {
                self.left = 31;
            } else if self.clock && !clock {
                self.left = self.left.saturating_sub(1);
            }
            (self.selected, self.clock) = (selected, clock);
        }

        fn line(&self) -> bool {
            self.selected && self.word >> self.left & 1 != 0
        }
    }

    /// Returns the chip's word for temperatures in °C, rounded as the chip does.
    #[expect(clippy::cast_possible_truncation, reason = "the chip does as well")]
    fn word(tip: f64, chip: f64) -> u32 {
        let tip = ((tip * 4.0).round() as i32).cast_unsigned();
        let chip = ((chip * 16.0).round() as i32).cast_unsigned();
        tip << 18 | (chip & 0xFFF) << 4
    }

    /// Runs a bench with chips for n cycles, in this order: function, read the lines, write them.
    fn runs(bench: &Bench, chips: &mut [Chip], n: usize) {
        for _ in 0..n {
            bench.run("max31855.0.bitbang-spi", 1_000_000);
            for (i, chip) in chips.iter().enumerate() {
                bench.set(&format!("max31855.0.data.{i}.in"), chip.line());
            }
            let selected = !bench.get::<bool>("max31855.0.cs.out");
            let clock = bench.get("max31855.0.clk.out");
            chips.iter_mut().for_each(|c| c.sees(selected, clock));
        }
    }

    fn celsius(bench: &Bench, i: usize) -> f64 {
        bench.get(&format!("max31855.0.temp-celsius.{i}"))
    }

    #[test]
    fn chips_with_the_tables_temperatures() {
        let mut bench = Bench::new();
        bench.load::<Max31855>(&["personality=3"]).unwrap();
        let mut chips = [Chip::new(0), Chip::new(0), Chip::new(0)];
        runs(&bench, &mut chips, 131);
        // Temperatures of tip and chip, and the voltages of both from IEC 60584-1.
        for (tip, v, at, u) in [
            (100.0, 4.096, 25.0, 1.0),
            (100.0, 4.096, 0.0, 0.0),
            (500.0, 20.644, 50.0, 2.023),
            (1000.0, 41.276, 10.0, 0.397),
            (1300.0, 52.410, 25.0, 1.0),
            (-100.0, -3.554, 25.0, 1.0),
            (-50.0, -1.889, -10.0, -0.392),
            (0.0, 0.0, 25.0, 1.0),
        ] {
            let told = at + (v - u) / 0.041_276;
            chips[1].word = word(told, at);
            runs(&bench, &mut chips, 130);
            // The chip rounds to a quarter of a degree; half of that, rounded, gives an error of up to 0.17.
            let found = celsius(&bench, 1);
            assert!((found - tip).abs() < 0.25, "{tip} °C at {at} °C: {found}");
            let kelvin: f64 = bench.get("max31855.0.temp-kelvin.1");
            assert!((kelvin - found - 273.15).abs() < 1e-3);
            let fahrenheit: f64 = bench.get("max31855.0.temp-fahrenheit.1");
            assert!((fahrenheit - 32.0 - found * 1.8).abs() < 1e-3);
            assert!(celsius(&bench, 0).abs() < 1e-6 && celsius(&bench, 2).abs() < 1e-6);
        }
    }

    /// Words, with the results of LinuxCNC's component.
    #[test]
    fn words_to_the_last_bit() {
        let mut bench = Bench::new();
        bench.load::<Max31855>(&["personality=1"]).unwrap();
        let mut chips = [Chip::new(0)];
        runs(&bench, &mut chips, 131);
        for (word, celsius, fahrenheit, kelvin) in [
            (0x00000000, 5.626643329037506e-08, 32.0, 273.1499938964844),
            (0x06401900, 99.9618911743164, 211.931396484375, 373.11187744140625),
            (0x40000000, 1025.4869384765625, 1877.87646484375, 1298.636962890625),
            (0x7ffc0000, 2047.75, 3717.949951171875, 2320.89990234375),
            (0x1f400190, 499.7775573730469, 931.599609375, 772.9275512695312),
            (0xc1800000, -2627465216.0, -4729437184.0, -2627464960.0),
            (0xfe70f380, -25.98552894592285, -14.77395248413086, 247.1644744873047),
            (0x53580000, 1333.5, 2432.300048828125, 1606.6500244140625),
            (0x06401900, 99.9618911743164, 211.931396484375, 373.11187744140625),
            (0x00000ff0, -0.5853027105331421, 30.946455001831055, 272.564697265625),
            (0x12345678, 294.68701171875, 562.4366455078125, 567.8370361328125),
        ] {
            chips[0].word = word;
            runs(&bench, &mut chips, 130);
            let is = ["celsius", "fahrenheit", "kelvin"]
                .map(|p| bench.get::<f64>(&format!("max31855.0.temp-{p}.0")));
            assert_eq!(is, [celsius, fahrenheit, kelvin], "{word:08x}");
        }
    }

    #[test]
    fn faults_keep_the_temperature() {
        let mut bench = Bench::new();
        bench.load::<Max31855>(&["personality=2"]).unwrap();
        let mut chips = [Chip::new(word(100.0, 25.0)), Chip::new(0)];
        runs(&bench, &mut chips, 131 + 130);
        let before = celsius(&bench, 0);
        assert!(before > 90.0);
        for (faults, said) in [
            (1, vec!["max31855: sensor 0 detected fault 1"]),
            (1, vec![]),
            (6, vec!["max31855: sensor 0 detected fault 6"]),
            (0, vec![]),
            (4, vec!["max31855: sensor 0 detected fault 4"]),
        ] {
            chips[0].word = word(50.0, 25.0) | faults;
            runs(&bench, &mut chips, 130);
            assert_eq!(bench.said(), said);
            assert_eq!(bench.get::<u32>("max31855.0.fault-flags.0"), faults);
            assert_eq!(bench.get::<bool>("max31855.0.fault.0"), faults != 0);
            assert!(!bench.get::<bool>("max31855.0.fault.1"));
            let now = celsius(&bench, 0);
            if faults == 0 {
                assert!(now < 60.0);
            } else if faults != 4 {
                assert_eq!(now, before);
            }
        }
    }

    #[test]
    fn bits_on_the_bus() {
        let mut bench = Bench::new();
        bench.load::<Max31855>(&[]).unwrap();
        let mut seen = Vec::new();
        for _ in 0..131 + 130 {
            bench.run("max31855.0.bitbang-spi", 1_000_000);
            seen.push((bench.get::<bool>("max31855.0.cs.out"), bench.get("max31855.0.clk.out")));
        }
        for (i, (cs, clock)) in seen.into_iter().enumerate() {
            let run = if i < 131 { i } else { i - 130 };
            assert_eq!((cs, clock), (run >= 66, run % 2 == 0), "run {i}");
        }
    }

    #[test]
    fn too_many_chips() {
        for wrong in ["16", "-1", "4294967295"] {
            let mut bench = Bench::new();
            let said = bench.load::<Max31855>(&[&format!("personality={wrong}")]).unwrap_err();
            let wanted = format!("personality={wrong} is not a number of chips, 0 to 15");
            assert_eq!(said, wanted);
            assert!(bench.names().is_empty());
        }
    }
}
