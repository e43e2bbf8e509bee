//! Realtime. Quadrature counters.

use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Reads, Writes},
    plan::{Place, ReadAnswer},
};
use core::sync::atomic::{
    AtomicBool,
    Ordering::{Acquire, Release},
};
use hal_component::{Error, Gives, In, Io, Messages, Out, ParamRw, Takes, Touch, Uses, pins};
use hal_firmware::{Module, Register, Tag, registers};

/// Bits of the control register.
mod bits {
    pub(super) const INPUT_A: u32 = 1;
    pub(super) const INPUT_B: u32 = 1 << 1;
    pub(super) const INPUT_INDEX: u32 = 1 << 2;
    /// 1 for the rising edge of the index.
    pub(super) const INDEX_RISES: u32 = 1 << 3;
    /// Latches the count at the index.
    pub(super) const LATCH_ON_INDEX: u32 = 1 << 4;
    /// The card clears the bits that latch when it has.
    pub(super) const JUST_ONCE: u32 = 1 << 6;
    pub(super) const MASK_POLARITY: u32 = 1 << 8;
    pub(super) const INDEX_MASK: u32 = 1 << 9;
    pub(super) const STEP_AND_DIRECTION: u32 = 1 << 10;
    pub(super) const FILTER: u32 = 1 << 11;
    pub(super) const PROBE_RISES: u32 = 1 << 12;
    pub(super) const LATCH_ON_PROBE: u32 = 1 << 13;
    pub(super) const ERROR: u32 = 1 << 15;
}

pins! {
    /// Results of one counter.
    struct Feedback {
        /// Counts since the card was found.
        rawcounts: Out<i32> = "rawcounts", 0;
        /// Counts since `reset` or the index.
        count: Out<i32> = "count", 0;
        /// Position, in units: `count` over `scale`.
        position: Out<f64> = "position", 0.0, measured;
        /// Counts at the last edge of the probe input, before `reset` or the index.
        rawlatch: Out<i32> = "rawlatch", 0;
        /// Counts at the last edge of the probe input.
        count_latched: Out<i32> = "count-latched", 0;
        /// Position at the last edge of the probe input, in units.
        position_latched: Out<f64> = "position-latched", 0.0;
        /// Speed, in units per second, from the times of the counts.
        velocity: Out<f64> = "velocity", 0.0;
        /// Speed, in units per minute.
        velocity_rpm: Out<f64> = "velocity-rpm", 0.0;
        /// TRUE once A and B changed together, while `quad-error-enable` is TRUE.
        quad_error: Out<bool> = "quad-error", false;
        /// Level of input A behind the filter.
        input_a: Out<bool> = "input-a", false;
        /// Level of input B behind the filter.
        input_b: Out<bool> = "input-b", false;
        /// Level of the index input behind the filter.
        input_index: Out<bool> = "input-index", false;
    }
}

pins! {
    /// Commands to one counter.
    struct Commands {
        /// TRUE to hold count and position at 0.
        reset: In<bool> = "reset", false;
        /// TRUE to make count and position 0 at the next edge of the index; the driver sets it FALSE then.
        index_enable: Io<bool> = "index-enable", false;
        /// TRUE to report that A and B changed together; FALSE clears the report.
        quad_error_enable: In<bool> = "quad-error-enable", false;
        /// Counts per unit; 0 counts as 1.
        scale: ParamRw<f64> = "scale", 1.0;
        /// TRUE for the rising edge of the index, FALSE for the falling one.
        index_invert: ParamRw<bool> = "index-invert", false;
        /// TRUE if the index counts only with the mask input.
        index_mask: ParamRw<bool> = "index-mask", false;
        /// TRUE if the mask input must be FALSE.
        index_mask_invert: ParamRw<bool> = "index-mask-invert", false;
        /// FALSE for quadrature, TRUE for step on A and direction on B.
        counter_mode: ParamRw<bool> = "counter-mode", false;
        /// TRUE to take an edge after 15 equal samples, FALSE after 3.
        filter: ParamRw<bool> = "filter", true;
        /// Longest time without a count before the speed counts as 0, in seconds.
        vel_timeout: ParamRw<f64> = "vel-timeout", 0.5;
    }
}

pins! {
    /// Commands to the latch of a counter whose card has a probe input.
    struct Probe {
        /// TRUE to latch the count at the next edge of the probe input; the driver sets it FALSE then.
        latch_enable: Io<bool> = "latch-enable", false;
        /// TRUE for the rising edge of the probe input, FALSE for the falling one.
        latch_polarity: In<bool> = "latch-polarity", false;
    }
}

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

/// Latches that the writing half has armed.
#[derive(Debug, Default)]
struct Armed {
    index: AtomicBool,
    probe: AtomicBool,
}

/// Half of a counter that reads.
#[derive(Touch)]
struct Counter {
    #[state]
    count: Place,
    #[state]
    control: Place,
    feedback: Feedback,
    commands: Commands,
    probe: Option<Probe>,
    armed: Takes<Armed>,
    messages: Messages,
    #[state]
    number: [f64; 2],
    #[state]
    state: Counting,
}

/// Counts of one counter so far.
#[derive(Default)]
struct Counting {
    last: Option<u16>,
    raw: i64,
    zero: i64,
    latched: i64,
    /// Moment of the last count, in ticks of the time stamps.
    counted_at: i64,
    velocity: f64,
    is_wrong: bool,
}

/// Time stamps of the module in this cycle.
#[derive(Clone, Copy)]
struct Stamp {
    /// Ticks so far.
    now: i64,
    /// The card's counter of ticks, which goes round.
    register: u16,
    /// Seconds of a tick.
    tick: f64,
}

impl Counter {
    fn read(&mut self, answer: ReadAnswer<'_>, stamp: Stamp, fresh: bool) {
        let [count_low, count_high, at_low, at_high] = answer.get(self.count).to_le_bytes();
        let count = u16::from_le_bytes([count_low, count_high]);
        let at = u16::from_le_bytes([at_low, at_high]);
        let control = answer.get(self.control);
        let s = &mut self.state;
        let moved = i64::from(count.wrapping_sub(s.last.unwrap_or(count)).cast_signed());
        s.last = Some(count);
        s.raw = s.raw.wrapping_add(moved);
        let latched = |raw: i64| {
            let [_, _, low, high] = control.to_le_bytes();
            let back = count.wrapping_sub(u16::from_le_bytes([low, high])).cast_signed();
            raw.wrapping_sub(i64::from(back))
        };
        // A latch counts only if the card is known to have been armed: an answer of a card that missed the order looks as
        // if the edge had come.
        let done = |bit: u32, armed: &AtomicBool| {
            fresh && armed.load(Acquire) && control & bit == 0 // Pairs with Release in `write`.
        };
        if done(bits::LATCH_ON_INDEX, &self.armed.index) && self.commands.index_enable.get() {
            s.zero = latched(s.raw);
            self.commands.index_enable.set(false);
        }
        if let Some(probe) = &self.probe
            && probe.latch_enable.get()
            && done(bits::LATCH_ON_PROBE, &self.armed.probe)
        {
            s.latched = latched(s.raw);
            probe.latch_enable.set(false);
        }
        if self.commands.reset.get() {
            s.zero = s.raw;
        }
        let scale = scale(self.commands.scale);
        s.follow(moved, at, stamp, self.commands.vel_timeout.get());
        let out = &self.feedback;
        out.rawcounts.set(low(s.raw));
        out.count.set(low(s.raw.wrapping_sub(s.zero)));
        out.position.set(s.raw.wrapping_sub(s.zero) as f64 / scale);
        out.rawlatch.set(low(s.latched));
        out.count_latched.set(low(s.latched.wrapping_sub(s.zero)));
        out.position_latched.set(s.latched.wrapping_sub(s.zero) as f64 / scale);
        out.velocity.set(s.velocity / scale);
        out.velocity_rpm.set(s.velocity / scale * 60.0);
        out.input_a.set(control & bits::INPUT_A != 0);
        out.input_b.set(control & bits::INPUT_B != 0);
        out.input_index.set(control & bits::INPUT_INDEX != 0);
        let is_wrong = self.commands.quad_error_enable.get() && control & bits::ERROR != 0;
        if is_wrong && !s.is_wrong {
            self.messages.error(WRONG, &self.number);
        }
        s.is_wrong = is_wrong;
        out.quad_error.set(is_wrong);
    }
}

const WRONG: &str = "card {}: encoder {}: A and B changed together: counts are lost (a frequency above \
    what the filter lets through, or a bad line)";

impl Counting {
    /// Follows the speed in counts per second. Between two counts it is at most what one count since the last would be.
    fn follow(&mut self, moved: i64, at: u16, stamp: Stamp, timeout: f64) {
        if moved != 0 {
            let ago = i64::from(stamp.register.wrapping_sub(at));
            let counted_at = stamp.now.wrapping_sub(ago);
            let ticks = counted_at.wrapping_sub(self.counted_at).max(1);
            self.velocity = moved as f64 / (ticks as f64 * stamp.tick);
            self.counted_at = counted_at;
            return;
        }
        let since = stamp.now.wrapping_sub(self.counted_at) as f64 * stamp.tick;
        if since > timeout || since.is_nan() || timeout.is_nan() {
            self.velocity = 0.0;
        } else if self.velocity.abs() * since > 1.0 {
            self.velocity = libm::copysign(1.0 / since, self.velocity);
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the pin goes round")]
const fn low(counts: i64) -> i32 {
    counts as i32
}

/// Returns the counts per unit; corrects 0 and NaN.
fn scale(scale: ParamRw<f64>) -> f64 {
    let value = scale.get();
    if value.is_finite() && value.abs() >= 1e-20 {
        return value;
    }
    scale.set(1.0);
    1.0
}

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
        self.control.put(to, control);
        // Pairs with Acquire in `read`.
        self.armed.index.store(index, Release);
        self.armed.probe.store(probe, Release);
    }
}

/// Function half that reads.
#[derive(Touch)]
struct Counters {
    counters: Vec<Counter>,
    #[state]
    stamp: Place,
    #[state]
    register: Option<u16>,
    #[state]
    now: i64,
    tick: Takes<Tick>,
}

/// Seconds of a tick of the time stamps, as bits.
type Tick = core::sync::atomic::AtomicU64;

impl Reads for Counters {
    fn read(&mut self, answer: ReadAnswer<'_>, _: Cycle, fresh: bool) {
        let [low, high, _, _] = answer.get(self.stamp).to_le_bytes();
        let register = u16::from_le_bytes([low, high]);
        let passed = register.wrapping_sub(self.register.unwrap_or(register));
        self.register = Some(register);
        self.now = self.now.wrapping_add(i64::from(passed));
        let tick = f64::from_bits(self.tick.load(Acquire)); // Pairs with Release in `write`.
        let stamp = Stamp { now: self.now, register, tick };
        for counter in &mut self.counters {
            counter.read(answer, stamp, fresh);
        }
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
        let ticks = divisor(self.clock, rate, 65_535.0);
        self.divisor.put(to, ticks);
        let tick = (f64::from(ticks) + 2.0) / self.clock;
        self.tick.store(tick.to_bits(), Release); // Pairs with Acquire in `read`.
        let rate = divisor(self.clock, f64::from(self.sample_frequency.get()), 4095.0);
        let skew = self.skew.map_or(0.0, |ns| f64::from(ns.get()) * self.clock * 1e-9);
        self.filter.put(to, rate | whole(skew) << 28);
        if let Some(Timer(timer, register)) = &mut self.timer {
            register.put(to, super::timer(*timer));
        }
        for counter in &mut self.counters {
            counter.write(to);
        }
    }
}

/// Returns a number of four bits.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
fn whole(x: f64) -> u32 {
    (x as u32).min(15)
}

/// Returns the register of a rate: periods of the clock less two.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it is within the limits"
)]
fn divisor(clock: f64, rate: f64, most: f64) -> u32 {
    let divisor = libm::floor(clock / rate + 0.5) - 2.0;
    if divisor >= 1.0 { if divisor < most { divisor as u32 } else { most as u32 } } else { 0 }
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
    let (gives, takes) = m.b.shared(Tick::new(0));
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
        number: [m.number, f64::from(instance)],
        state: Counting::default(),
    };
    let control = Kept::new(m.address(module, kind.control, instance)?);
    Ok((read, Arming { commands, probe, armed: gives, control }))
}

/// Number of a counter's probe input among its I/O pins.
const PROBE_PIN: u8 = 5;
