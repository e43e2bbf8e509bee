//! Realtime. Quadrature counters.

mod counter;

use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Writes},
    numbers::whole,
};
use core::sync::atomic::Ordering::{Acquire, Release};
use counter::{Armed, Commands, Counter, Counters, Counting, Feedback, Probe, Tick, WRONG, bits};
use hal_component::{Error, Gives, In, Touch, Uses, lasting};
use hal_firmware::{Module, Register, Tag, registers};

/// Kind of module: its tag and registers. Both kinds make the same pins.
struct CounterKind {
    tag: Tag,
    count: Register,
    control: Register,
    stamp_divisor: Register,
    stamp: Register,
    filter_rate: Register,
    timer: Register,
    /// Name, default and meaning of the pin that sets the rate of the samples.
    rate: (&'static str, u32, &'static str),
}

const KINDS: [CounterKind; 2] = [
    CounterKind {
        tag: Tag::Encoder,
        count: registers::ENCODER_COUNT,
        control: registers::ENCODER_CONTROL,
        stamp_divisor: registers::ENCODER_STAMP_DIVISOR,
        stamp: registers::ENCODER_STAMP,
        filter_rate: registers::ENCODER_FILTER_RATE,
        timer: registers::ENCODER_TIMER,
        rate: (
            "sample-frequency",
            25_000_000,
            "Rate at which the inputs are sampled, in hertz; values out of range saturate",
        ),
    },
    CounterKind {
        tag: Tag::MuxedEncoder,
        count: registers::MUXED_COUNT,
        control: registers::MUXED_CONTROL,
        stamp_divisor: registers::MUXED_STAMP_DIVISOR,
        stamp: registers::MUXED_STAMP,
        filter_rate: registers::MUXED_FILTER_RATE,
        timer: registers::MUXED_TIMER,
        rate: (
            "muxed-sample-frequency",
            8_333_333,
            "Rate at which the inputs are sampled and the halves are changed, in hertz; values out \
             of range saturate",
        ),
    },
];

/// Half of a counter that writes.
#[derive(Touch)]
struct Arming {
    commands: Commands,
    probe: Option<Probe>,
    armed: Gives<Armed>,
    #[state]
    control: Kept,
}

impl Arming {
    fn write(&mut self, to: &mut Outgoing<'_>) {
        let c = &self.commands;
        let index = c.index_enable.get();
        let probe = self.probe.as_ref().is_some_and(|probe| probe.latch_enable.get());
        let rises = self.probe.as_ref().is_some_and(|probe| probe.latch_polarity.get());
        let mut control = 0;
        let mut set = |is_set: bool, bit: u32| control |= if is_set { bit } else { 0 };
        set(index, bits::LATCH_ON_INDEX | bits::JUST_ONCE);
        set(probe, bits::LATCH_ON_PROBE);
        set(rises, bits::PROBE_RISES);
        set(c.index_invert.get(), bits::INDEX_RISES);
        set(c.index_mask.get(), bits::INDEX_MASK);
        set(c.index_mask_invert.get(), bits::MASK_POLARITY);
        set(c.counter_mode.get(), bits::STEP_AND_DIRECTION);
        set(c.filter.get(), bits::FILTER);
        // Writing 0 clears the error.
        set(c.quad_error_enable.get(), bits::ERROR);
        // The card has cleared its bit if it has latched: the register then holds another value than the last one written.
        let index_done = index && !self.armed.index.load(Acquire);
        let probe_done = probe && !self.armed.probe.load(Acquire);
        if index_done || probe_done {
            self.control.forget();
        }
        self.control.put(to, control);
        // Pairs with Acquire in `read`.
        self.armed.index.store(index, Release);
        self.armed.probe.store(probe, Release);
    }
}

/// Function half that writes.
#[derive(Touch)]
struct Counts {
    counters: Vec<Arming>,
    sample_frequency: In<u32>,
    skew: Option<In<u32>>,
    hires: In<bool>,
    tick: Gives<Tick>,
    timer: Option<Timer>,
    #[state]
    clock: f64,
    #[state]
    divisor: Kept,
    #[state]
    filter: Kept,
}

/// Parameter and register that select the timer which latches the counts.
struct Timer(In<i32>, Kept);

impl Touch for Timer {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
    }
}

impl Writes for Counts {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        let rate = if self.hires.get() { 10e6 } else { 2e6 };
        let ticks = divisor(self.clock, rate, 65_535);
        self.divisor.put(to, ticks);
        let tick = (f64::from(ticks) + 2.0) / self.clock;
        self.tick.store(tick.to_bits(), Release); // Pairs with Acquire in `read`.
        let rate = divisor(self.clock, f64::from(self.sample_frequency.get()), 4095);
        let skew = self.skew.map_or(0.0, |ns| f64::from(ns.get()) * self.clock * 1e-9);
        self.filter.put(to, rate | whole(skew, 15) << 28);
        if let Some(Timer(timer, register)) = &mut self.timer {
            register.put(to, super::timer(*timer));
        }
        for counter in &mut self.counters {
            counter.write(to);
        }
    }
}

/// Returns the register of a rate: periods of the clock less two.
fn divisor(clock: f64, rate: f64, most: u32) -> u32 {
    whole(libm::floor(clock / rate + 0.5) - 2.0, most)
}

/// Creates the pins of all counters.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    KINDS.iter().try_for_each(|kind| make_kind(m, kind))
}

fn make_kind(m: &mut Making<'_, '_>, kind: &CounterKind) -> Result<(), Error> {
    let Some((module, used)) = m.module(kind.tag) else { return Ok(()) };
    let (mut reads, mut writes) = (Vec::new(), Vec::new());
    for instance in 0..used {
        let (read, write) = counter(m, kind, &module, instance)?;
        reads.push(read);
        writes.push(write);
    }
    let (pin, default, about) = kind.rate;
    let name = m.at(&format!("encoder.{pin}"));
    let sample_frequency = m.b.item(&name, about, default)?;
    let about = "True for time stamps of about 10 MHz, false for about 2 MHz";
    let name = m.at("encoder.hires-timestamp");
    let hires = m.b.item(&name, about, false)?;
    let skew = if kind.tag == Tag::MuxedEncoder {
        let about = "Delay of the samples behind the change of halves, in nanoseconds; 0 to 15 periods of the clock";
        let name = m.at("encoder.muxed-skew");
        Some(m.b.item(&name, about, 0)?)
    } else {
        None
    };
    let timer = match m.timer(&module, kind.timer) {
        Some(at) => {
            let name = m.at("encoder.timer-number");
            Some(Timer(m.b.item(&name, super::TIMER, -1)?, Kept::new(at)))
        }
        None => None,
    };
    let clock = m.clock(&module)?;
    // Before the first write, time stamps count at 2 MHz.
    let (gives, takes) = m.b.shared(Tick::new(0.5e-6_f64.to_bits()));
    let stamp = m.read(&module, kind.stamp, 0)?;
    m.reads.push(Box::new(Counters {
        counters: reads,
        stamp,
        register: None,
        now: 0,
        tick: takes,
    }));
    m.writes.push(Box::new(Counts {
        counters: writes,
        sample_frequency,
        skew,
        hires,
        tick: gives,
        timer,
        clock,
        divisor: Kept::new(m.address(&module, kind.stamp_divisor, 0)?),
        filter: Kept::new(m.address(&module, kind.filter_rate, 0)?),
    }));
    Ok(())
}

fn counter(
    m: &mut Making<'_, '_>,
    kind: &CounterKind,
    module: &Module,
    instance: u8,
) -> Result<(Counter, Arming), Error> {
    let name = m.at(&format!("encoder.{instance:02}"));
    let feedback = Feedback::make(m.b, &name)?;
    let commands = Commands::make(m.b, &name)?;
    let probe = if m.has_pin(kind.tag, instance, PROBE_PIN) {
        Some(Probe::make(m.b, &name)?)
    } else {
        None
    };
    m.encoder_scales.push(commands.scale);
    let (gives, takes) = m.b.shared(Armed::default());
    let count = m.read(module, kind.count, instance)?;
    let control = m.read(module, kind.control, instance)?;
    let read = Counter {
        count,
        control,
        feedback,
        commands: commands.clone(),
        probe: probe.clone(),
        armed: takes,
        messages: m.b.messages(),
        wrong: lasting(format!("{name}: {WRONG}")),
        state: Counting::default(),
    };
    let control = Kept::new(m.address(module, kind.control, instance)?);
    Ok((read, Arming { commands, probe, armed: gives, control }))
}

/// Number of a counter's probe input among its I/O pins.
const PROBE_PIN: u8 = 5;
