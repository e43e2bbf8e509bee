//! Realtime. Inputs with filters, as the cards with screw terminals have them, and scanned ones.

use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Reads, Writes},
    plan::{Answer, Place},
};
use hal_component::{Error, In, Out, ParamRw, Touch};
use hal_firmware::{Module, Register, Tag, registers};

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

/// One input.
#[derive(Touch)]
struct Input {
    level: Out<bool>,
    not: Out<bool>,
    raw: Out<bool>,
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
            slow: m.b.item(&at("input", "-slow"), "True for the long filter", false)?,
        })
    }
}

/// One hand wheel on two neighbouring inputs.
#[derive(Touch)]
struct Wheel {
    count: Out<i32>,
    every_edge: In<bool>,
    reset: In<bool>,
}

impl Wheel {
    fn make(m: &mut Making<'_, '_>, bank: &str, n: u8) -> Result<Self, Error> {
        let at = |behind: &str| format!("{bank}.enc{n}-{behind}");
        let about = "True to count each edge, false to count whole cycles";
        Ok(Self {
            count: m.b.item(&at("count"), "Counts of the hand wheel", 0)?,
            every_edge: m.b.item(&at("4xmode"), about, false)?,
            reset: m.b.item(&at("reset"), "True to hold the count at 0", false)?,
        })
    }
}

/// One instance.
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
    fn read(&mut self, answer: Answer<'_>, _: Cycle, _: bool) {
        for bank in &mut self.banks {
            let (filtered, raw) = (answer.get(bank.filtered), answer.get(bank.raw));
            for (n, input) in bank.inputs.iter().enumerate() {
                let level = filtered >> n & 1 == 1;
                input.level.set(level);
                input.not.set(!level);
                input.raw.set(raw >> n & 1 == 1);
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
    every_edge: Vec<In<bool>>,
    rate: ParamRw<u32>,
    fast: ParamRw<u32>,
    long: ParamRw<u32>,
    #[state]
    clock: f64,
    #[state]
    control: Kept,
    #[state]
    filter: Kept,
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
        let set = |pins: &[In<bool>]| {
            let bits = (0..32).zip(pins).map(|(n, pin)| u32::from(pin.get()) << n);
            bits.fold(0, |all, bit| all | bit)
        };
        let inputs = u32::try_from(self.slow.len()).unwrap_or(32);
        let rate = f64::from(self.rate.get().max(1));
        let divisor = whole(libm::floor(self.clock / rate + 0.5) - 1.0, 1023);
        let fast = self.fast.get().min(31);
        let long = self.long.get().min(1023);
        let control = inputs & 0x1F
            | divisor << 6
            | fast << 16
            | long << 22
            | (set(&self.every_edge) & 0xF) << 28;
        self.control.put(to, control);
        self.filter.put(to, set(&self.slow));
    }
}

/// Returns a number limited to what a register holds.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
fn whole(x: f64, most: u32) -> u32 {
    (x as u32).min(most)
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
    for n in 0..m.inputs(kind.tag, instance) {
        inputs.push(Input::make(m, &name, n)?);
    }
    let mut wheels = Vec::new();
    for n in 0..4 {
        wheels.push(WheelCount { pins: Wheel::make(m, &name, n)?, last: None, count: 0 });
    }
    let about = "Rate of the samples, in hertz; values out of range saturate";
    let rate = m.b.item(&format!("{name}.scan_rate"), about, 20_000)?;
    let about = "Samples that must agree with the short filter; 0 to 31";
    let fast = m.b.item(&format!("{name}.fast_scans"), about, 5)?;
    let about = "Samples that must agree with the long filter; 0 to 1023";
    let long = m.b.item(&format!("{name}.slow_scans"), about, 500)?;
    let scan = Scan {
        slow: inputs.iter().map(|input| input.slow).collect(),
        every_edge: wheels.iter().map(|wheel| wheel.pins.every_edge).collect(),
        rate,
        fast,
        long,
        clock: m.clock(module)?,
        control: Kept::new(m.address(module, kind.control, instance)?),
        filter: Kept::new(m.address(module, kind.filter, instance)?),
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
