//! Realtime. Inputs with filters, as the cards with screw terminals have them, and scanned ones.

use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Reads, Writes},
    numbers::whole,
    plan::{Place, ReadAnswer},
};
use hal_component::{Error, In, Out, ParamRo, ParamRw, Touch};
use hal_firmware::{Module, Register, Tag, registers};

/// Periods of the clock that one period of the samples' divisor counts.
const PRESCALE: f64 = 4.0;

/// Bit of the control register for inputs that are active at a low level, as those of all cards are.
const ACTIVE_LOW: u32 = 1 << 5;

/// Kind of module: its tag and registers, and how they are named.
struct InputKind {
    tag: Tag,
    name: &'static str,
    control: Register,
    filter: Register,
    filtered: Register,
    raw: Register,
    wheels: Register,
}

const KINDS: [InputKind; 2] = [
    InputKind {
        tag: Tag::Inputs,
        name: "inm",
        control: registers::INPUTS_CONTROL,
        filter: registers::INPUTS_FILTER,
        filtered: registers::INPUTS_FILTERED,
        raw: registers::INPUTS_RAW,
        wheels: registers::INPUTS_WHEELS,
    },
    InputKind {
        tag: Tag::InputMux,
        name: "inmux",
        control: registers::INMUX_CONTROL,
        filter: registers::INMUX_FILTER,
        filtered: registers::INMUX_FILTERED,
        raw: registers::INMUX_RAW,
        wheels: registers::INMUX_WHEELS,
    },
];

/// Input with its filter.
#[derive(Touch)]
struct Input {
    level: Out<bool>,
    not: Out<bool>,
    raw: Out<bool>,
    raw_not: Out<bool>,
    slow: In<bool>,
}

impl Input {
    fn make(m: &mut Making<'_, '_>, bank: &str, n: u8) -> Result<Self, Error> {
        let at = |what: &str, behind: &str| format!("{bank}.{what}-{n:02}{behind}");
        Ok(Self {
            level: m.b.item(&at("input", ""), "Level behind the filter", false)?,
            not: m.b.item(
                &at("input", "-not"),
                "Opposite of the level behind the filter",
                false,
            )?,
            raw: m.b.item(&at("raw-input", ""), "Level at the I/O pin", false)?,
            raw_not: m.b.item(
                &at("raw-input", "-not"),
                "Opposite of the level at the I/O pin",
                false,
            )?,
            slow: m.b.item(&at("input", "-slow"), "True for the long filter", false)?,
        })
    }
}

/// Hand wheel on two neighbouring inputs.
#[derive(Touch)]
struct Wheel {
    count: Out<i32>,
    every_edge: ParamRw<bool>,
    reset: In<bool>,
}

impl Wheel {
    fn make(m: &mut Making<'_, '_>, bank: &str, n: u8) -> Result<Self, Error> {
        let at = |behind: &str| format!("{bank}.enc{n}-{behind}");
        let about = "True to count each edge, false to count whole cycles";
        Ok(Self {
            count: m.b.item(&at("count"), "Counts of the hand wheel", 0)?,
            every_edge: m.b.item(&format!("{bank}.enc{n}_4xmode"), about, false)?,
            reset: m.b.item(&at("reset"), "True to hold the count at 0", false)?,
        })
    }
}

/// Inputs of an instance.
#[derive(Touch)]
struct Bank {
    inputs: Vec<Input>,
    wheels: Vec<WheelCount>,
    #[state]
    filtered: Place,
    #[state]
    raw: Place,
    #[state]
    turns: Place,
}

/// A hand wheel with what the card counted last.
#[derive(Touch)]
struct WheelCount {
    pins: Wheel,
    #[state]
    last: Option<u8>,
    #[state]
    count: i32,
}

/// Function half that reads.
#[derive(Touch)]
struct Banks {
    banks: Vec<Bank>,
}

impl Reads for Banks {
    fn read(&mut self, answer: ReadAnswer<'_>, _: Cycle, _: bool) {
        for bank in &mut self.banks {
            let (filtered, raw) = (answer.get(bank.filtered), answer.get(bank.raw));
            for (n, input) in bank.inputs.iter().enumerate() {
                let level = filtered >> n & 1 == 1;
                input.level.set(level);
                input.not.set(!level);
                let level = raw >> n & 1 == 1;
                input.raw.set(level);
                input.raw_not.set(!level);
            }
            let turns = answer.get(bank.turns).to_le_bytes();
            for (wheel, now) in bank.wheels.iter_mut().zip(turns) {
                let moved = now.wrapping_sub(wheel.last.unwrap_or(now)).cast_signed();
                wheel.last = Some(now);
                wheel.count = wheel.count.wrapping_add(i32::from(moved));
                if wheel.pins.reset.get() {
                    wheel.count = 0;
                }
                wheel.pins.count.set(wheel.count);
            }
        }
    }
}

/// Settings of one instance.
#[derive(Touch)]
struct Scan {
    slow: Vec<In<bool>>,
    every_edge: Vec<ParamRw<bool>>,
    rate: ParamRw<u32>,
    fast: ParamRw<u32>,
    long: ParamRw<u32>,
    #[state]
    clock: f64,
    #[state]
    control: Kept,
    #[state]
    filter: Kept,
    #[state]
    wheels: Kept,
}

/// Function half that writes.
#[derive(Touch)]
struct Scans {
    scans: Vec<Scan>,
}

impl Writes for Scans {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        for scan in &mut self.scans {
            scan.write(to);
        }
    }
}

impl Scan {
    fn write(&mut self, to: &mut Outgoing<'_>) {
        let rate = f64::from(self.rate.get().max(1)) * self.slow.len() as f64;
        let divisor = whole(libm::floor(self.clock / PRESCALE / rate) - 1.0, 1023);
        let fast = self.fast.get().min(63);
        let long = self.long.get().min(1023);
        self.control.put(to, ACTIVE_LOW | divisor << 6 | fast << 16 | long << 22);
        self.filter.put(to, bits(self.slow.iter().map(In::get)));
        let mut modes = [0; 4];
        for (mode, every_edge) in modes.iter_mut().zip(&self.every_edge) {
            *mode = u8::from(every_edge.get());
        }
        self.wheels.put(to, u32::from_le_bytes(modes));
    }
}

/// Returns the bits of a row, the first at bit 0.
fn bits(row: impl Iterator<Item = bool>) -> u32 {
    (0..32).zip(row).fold(0, |all, (n, bit)| all | u32::from(bit) << n)
}

/// Creates the pins of all inputs.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    for kind in &KINDS {
        let Some((module, used)) = m.module(kind.tag) else { continue };
        let (mut banks, mut scans) = (Vec::new(), Vec::new());
        for instance in 0..used {
            let (bank, scan) = bank(m, kind, &module, instance)?;
            banks.push(bank);
            scans.push(scan);
        }
        m.reads.push(Box::new(Banks { banks }));
        m.writes.push(Box::new(Scans { scans }));
    }
    Ok(())
}

fn bank(
    m: &mut Making<'_, '_>,
    kind: &InputKind,
    module: &Module,
    instance: u8,
) -> Result<(Bank, Scan), Error> {
    let name = m.at(&format!("{}.{instance:02}", kind.name));
    let mut inputs = Vec::new();
    let [width, ..] = (m.peek(module, kind.control, instance)? & 0x1F).to_le_bytes();
    let width = width + 1;
    for n in 0..width {
        inputs.push(Input::make(m, &name, n)?);
    }
    let mut wheels = Vec::new();
    for n in 0..4 {
        wheels.push(WheelCount { pins: Wheel::make(m, &name, n)?, last: None, count: 0 });
    }
    let about = "Rate of the samples, in hertz; values out of range saturate";
    let rate = m.b.item(&format!("{name}.scan_rate"), about, 20_000)?;
    let about = "Samples that must agree with the short filter; 0 to 63";
    let fast = m.b.item(&format!("{name}.fast_scans"), about, 5)?;
    let about = "Samples that must agree with the long filter; 0 to 1023";
    let long = m.b.item(&format!("{name}.slow_scans"), about, 500)?;
    let about = "Number of inputs";
    let _: ParamRo<u32> = m.b.item(&format!("{name}.scan_width"), about, u32::from(width))?;
    let scan = Scan {
        slow: inputs.iter().map(|input| input.slow).collect(),
        every_edge: wheels.iter().map(|wheel| wheel.pins.every_edge).collect(),
        rate,
        fast,
        long,
        clock: m.clock(module)?,
        control: Kept::new(m.address(module, kind.control, instance)?),
        filter: Kept::new(m.address(module, kind.filter, instance)?),
        wheels: Kept::new(m.address(module, kind.wheels, instance)?),
    };
    let bank = Bank {
        inputs,
        wheels,
        filtered: m.read(module, kind.filtered, instance)?,
        raw: m.read(module, kind.raw, instance)?,
        turns: m.read(module, kind.wheels, instance)?,
    };
    Ok((bank, scan))
}
