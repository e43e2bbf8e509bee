//! Encoder counters, with the encoders that turn before them.
//!
//! Source: Mesa's `qcountersfpd.vhd`, `qcounterated.vhd` and `timestampd.vhd`, published under the BSD licence with 3
//! clauses. An encoder that turns so fast that the filter of its inputs would swallow it does not count.

use crate::timer::{Latched, Stamps};
use hal_firmware::registers as r;

// Numbers of registers.
const COUNT: u8 = r::ENCODER_COUNT.index;
const CONTROL: u8 = r::ENCODER_CONTROL.index;
const DIVISOR: u8 = r::ENCODER_STAMP_DIVISOR.index;
const STAMP: u8 = r::ENCODER_STAMP.index;
const TIMER: u8 = r::ENCODER_TIMER.index;
const FILTER_RATE: u8 = r::ENCODER_FILTER_RATE.index;

/// Bits of the control register.
const INDEX_POLARITY: u16 = 1 << 3;
const LATCH_ON_INDEX: u16 = 1 << 4;
const CLEAR_ON_INDEX: u16 = 1 << 5;
const JUST_ONCE: u16 = 1 << 6;
const GATE_INDEX: u16 = 1 << 7;
const MASK_POLARITY: u16 = 1 << 8;
const USE_MASK: u16 = 1 << 9;
const STEP_AND_DIRECTION: u16 = 1 << 10;
const LONG_FILTER: u16 = 1 << 11;
const PROBE_POLARITY: u16 = 1 << 12;
const LATCH_ON_PROBE: u16 = 1 << 13;
const GATE_POLARITY: u16 = 1 << 14;
const ERROR: u16 = 1 << 15;
/// Bits that the controller writes and reads back.
const KEPT: u16 = 0x7FF8;

/// All counters of a kind.
#[derive(Debug)]
pub(crate) struct Counters {
    all: Vec<Counter>,
    filter_rate: u32,
    stamps: Stamps,
    latched: Latched,
    latched_stamp: u16,
    span: Span,
}

/// Time that passes in one go, and how much of it is over.
#[derive(Clone, Copy, Debug, Default)]
struct Span {
    all: u64,
    done: u64,
}

/// Line of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EncoderLine {
    A,
    B,
    Index,
    Mask,
    Probe,
}

impl EncoderLine {
    /// Returns the line of an encoder's pin.
    pub(crate) const fn of_pin(number: u8) -> Option<Self> {
        match number {
            1 => Some(Self::A),
            2 => Some(Self::B),
            3 => Some(Self::Index),
            4 => Some(Self::Mask),
            5 => Some(Self::Probe),
            _ => None,
        }
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Lines {
    a: bool,
    b: bool,
    index: bool,
    mask: bool,
    probe: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Counter {
    control: u16,
    count: u16,
    stamp: u16,
    latch: u16,
    lines: Lines,
    /// Index as the control register has it: polarity, gate.
    index: bool,
    position: i64,
    start: i64,
    goal: i64,
    turn: Option<i64>,
    sampled: [u32; 2],
}

impl Counters {
    pub(crate) fn new(count: usize) -> Self {
        Self {
            all: vec![Counter::default(); count],
            filter_rate: 4,
            stamps: Stamps::default(),
            latched: Latched::default(),
            latched_stamp: 0,
            span: Span::default(),
        }
    }

    /// Begins a time, during which the encoders turn to their goals evenly.
    pub(crate) fn begin(&mut self, clock: u64) {
        self.span = Span { all: clock, done: 0 };
        for one in &mut self.all {
            one.start = one.position;
        }
    }

    pub(crate) const fn timers(&self) -> u8 {
        self.latched.timers()
    }

    pub(crate) fn advance(&mut self, clock: u64) {
        let sample = u64::from(self.filter_rate & 0x0FFF) + 2;
        for one in &mut self.all {
            one.turn(clock, self.span, sample, &self.stamps);
        }
        self.span.done += clock;
        self.stamps.advance(clock);
    }

    pub(crate) fn latch(&mut self, events: u8) {
        if self.latched.takes(events) {
            self.latched_stamp = self.stamps.counter;
            for one in &mut self.all {
                one.sampled = [one.data(), one.control()];
            }
        }
    }

    pub(crate) fn read(&self, register: u8, instance: u8) -> u32 {
        let one = self.all.get(usize::from(instance));
        let is_latched = self.latched.is_enabled();
        match register {
            COUNT => one.map_or(0, |o| if is_latched { o.sampled[0] } else { o.data() }),
            CONTROL => one.map_or(0, |o| if is_latched { o.sampled[1] } else { o.control() }),
            DIVISOR => self.stamps.divisor,
            STAMP if is_latched => u32::from(self.latched_stamp),
            STAMP => u32::from(self.stamps.counter),
            TIMER => self.latched.register(),
            _ => 0,
        }
    }

    pub(crate) fn write(&mut self, register: u8, instance: u8, value: u32) {
        match register {
            CONTROL => {
                if let Some(one) = self.all.get_mut(usize::from(instance)) {
                    let [low, high, ..] = value.to_le_bytes();
                    one.set_control(u16::from_le_bytes([low, high]));
                }
            }
            DIVISOR => (self.stamps.divisor, self.stamps.rest) = (value & 0xFFFF, 0),
            FILTER_RATE => self.filter_rate = value,
            TIMER => self.latched = Latched::from_register(value),
            _ => {}
        }
    }

    /// Returns the counts of the encoder's shaft.
    pub(crate) fn position(&self, instance: usize) -> Option<i64> {
        self.all.get(instance).map(|one| one.position)
    }

    /// Lets the encoder turn to these counts during the next time.
    pub(crate) fn turn_to(&mut self, instance: usize, counts: i64) {
        if let Some(one) = self.all.get_mut(instance) {
            one.goal = counts;
        }
    }

    /// Gives the encoder an index at each multiple of these counts.
    pub(crate) fn set_turn(&mut self, instance: usize, counts: u32) {
        let stamp = self.stamps.counter;
        if let Some(one) = self.all.get_mut(instance) {
            one.turn = (counts != 0).then_some(i64::from(counts));
            let index = one.index_at(one.position);
            one.change(Lines { index, ..one.lines }, stamp);
        }
    }

    pub(crate) fn line(&self, instance: usize, line: EncoderLine) -> bool {
        self.all.get(instance).is_some_and(|one| match line {
            EncoderLine::A => one.lines.a,
            EncoderLine::B => one.lines.b,
            EncoderLine::Index => one.lines.index,
            EncoderLine::Mask => one.lines.mask,
            EncoderLine::Probe => one.lines.probe,
        })
    }

    pub(crate) fn set_line(&mut self, instance: usize, line: EncoderLine, level: bool) {
        let stamp = self.stamps.counter;
        if let Some(one) = self.all.get_mut(instance) {
            let mut lines = one.lines;
            match line {
                EncoderLine::A => lines.a = level,
                EncoderLine::B => lines.b = level,
                EncoderLine::Index => lines.index = level,
                EncoderLine::Mask => lines.mask = level,
                EncoderLine::Probe => lines.probe = level,
            }
            one.change(lines, stamp);
        }
    }
}

impl Counter {
    fn data(&self) -> u32 {
        u32::from(self.stamp) << 16 | u32::from(self.count)
    }

    fn control(&self) -> u32 {
        let bit = |level: bool, bit: u32| u32::from(level) << bit;
        u32::from(self.latch) << 16
            | u32::from(self.control)
            | bit(self.lines.a, 0)
            | bit(self.lines.b, 1)
            | bit(self.index, 2)
    }

    const fn has(&self, bit: u16) -> bool {
        self.control & bit != 0
    }

    fn set_control(&mut self, value: u16) {
        let error = self.control & ERROR & !value;
        self.control = value & KEPT | error;
        self.follow_index();
    }

    fn index_at(&self, position: i64) -> bool {
        self.turn.is_some_and(|turn| position.rem_euclid(turn) == 0)
    }

    /// Turns the shaft on to its goal, evenly over the whole span.
    fn turn(&mut self, clock: u64, span: Span, sample: u64, stamps: &Stamps) {
        if self.position == self.goal {
            return;
        }
        let way = self.goal.abs_diff(self.start);
        let samples: u64 = if self.has(LONG_FILTER) { 15 } else { 3 };
        // A line stays for two counts; the filter takes it after as many samples.
        let is_seen = way.checked_mul(samples * sample).is_some_and(|time| time <= span.all * 2);
        if !is_seen {
            self.position = self.goal;
            let lines = Lines { index: self.index_at(self.goal), ..self.lines_at(self.goal) };
            if quadrature((self.lines.a, self.lines.b), (lines.a, lines.b)) == 2 {
                self.control |= ERROR;
            }
            self.lines = lines;
            self.index = self.index_level();
            return;
        }
        let step = if self.start < self.goal { 1 } else { -1 };
        let first = self.position.abs_diff(self.start) + 1;
        for nth in first..=way {
            let at = span.all * nth / way;
            if span.done + clock < at {
                return;
            }
            self.position += step;
            let lines = self.lines_at(self.position);
            self.change(lines, stamps.after(at.saturating_sub(span.done)));
        }
    }

    fn lines_at(&self, position: i64) -> Lines {
        let quarter = position & 3;
        let index = if self.turn.is_some() { self.index_at(position) } else { self.lines.index };
        Lines {
            a: quarter == 1 || quarter == 2,
            b: quarter == 2 || quarter == 3,
            index,
            ..self.lines
        }
    }

    /// Takes new levels of the lines.
    fn change(&mut self, lines: Lines, stamp: u16) {
        let before = core::mem::replace(&mut self.lines, lines);
        let probe = before.probe != lines.probe && lines.probe == self.has(PROBE_POLARITY);
        if probe && self.has(LATCH_ON_PROBE) {
            self.latch = self.count;
            self.disarm(LATCH_ON_PROBE);
        }
        // The index latches the count before the edge that comes with it.
        let cleared = self.follow_index();
        let (was, is) = ((before.a, before.b), (lines.a, lines.b));
        let step = if self.has(STEP_AND_DIRECTION) {
            match (was, is) {
                ((false, _), (true, true)) => 1,
                ((false, _), (true, false)) => -1,
                _ => 0,
            }
        } else {
            quadrature(was, is)
        };
        if step == 2 {
            self.control |= ERROR;
        } else if step != 0 {
            self.stamp = stamp;
            self.count = self.count.wrapping_add_signed(step);
        }
        if cleared {
            self.count = 0;
        }
    }

    fn index_level(&self) -> bool {
        let level = self.lines.index == self.has(INDEX_POLARITY);
        let gate = match (self.has(GATE_INDEX), self.has(GATE_POLARITY)) {
            (false, _) => true,
            (true, true) => self.lines.a && self.lines.b,
            (true, false) => !(self.lines.a || self.lines.b),
        };
        level && gate
    }

    /// Takes the level of the index, latches, and returns whether it clears the count.
    fn follow_index(&mut self) -> bool {
        let level = self.index_level();
        let rises = level && !self.index;
        self.index = level;
        let masked = self.has(USE_MASK) && self.lines.mask != self.has(MASK_POLARITY);
        if !rises || masked {
            return false;
        }
        if self.has(LATCH_ON_INDEX) {
            self.latch = self.count;
            self.disarm(LATCH_ON_INDEX);
        }
        let clears = self.has(CLEAR_ON_INDEX);
        if clears {
            self.disarm(CLEAR_ON_INDEX);
            self.count = 0;
        }
        clears
    }

    const fn disarm(&mut self, bit: u16) {
        if self.has(JUST_ONCE) {
            self.control &= !bit;
        }
    }
}

/// Returns the counts of a change of A and B; 2 if both changed.
const fn quadrature(was: (bool, bool), is: (bool, bool)) -> i16 {
    match (was.0 != is.0, was.1 != is.1) {
        (false, false) => 0,
        (true, true) => 2,
        // A leads B.
        (true, false) => {
            if is.0 == is.1 {
                -1
            } else {
                1
            }
        }
        (false, true) => {
            if is.0 == is.1 {
                1
            } else {
                -1
            }
        }
    }
}
