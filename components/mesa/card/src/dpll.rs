//! Clock that follows the controller's reads, with four timers.
//!
//! An accumulator of 42 bits turns once per period. With each read of `DPLL_SYNC` its phase is the error that the rate is
//! corrected by, through a filter. Source: Mesa's `hm2dpll.vhd`, published under the BSD licence with 3 clauses.

use hal_firmware::registers as r;

// Numbers of registers.
const BASE_RATE: u8 = r::DPLL_BASE_RATE.index;
const PHASE_ERROR: u8 = r::DPLL_PHASE_ERROR.index;
const CONTROL_0: u8 = r::DPLL_CONTROL_0.index;
const CONTROL_1: u8 = r::DPLL_CONTROL_1.index;
const TIMERS_12: u8 = r::DPLL_TIMERS_12.index;
const TIMERS_34: u8 = r::DPLL_TIMERS_34.index;
const SYNC: u8 = r::DPLL_SYNC.index;

const WIDTH: u32 = 42;
const TURN: i64 = 1 << WIDTH;
const LIMIT: i64 = 0x0070_0000;
/// Most updates of the filter in one run; a shorter time constant than this allows is lengthened.
const UPDATES: u64 = 4096;

/// Clock of a card.
#[derive(Debug)]
pub(crate) struct Dpll {
    base: i32,
    accumulator: i64,
    limit: i64,
    prescale: u64,
    prescaled: u64,
    constant: u64,
    until_update: u64,
    bounded: i64,
    filtered: i64,
    integral: i64,
    timers: [u16; 4],
}

impl Dpll {
    pub(crate) const fn new() -> Self {
        Self {
            base: 0,
            accumulator: 0,
            limit: 0,
            prescale: 1,
            prescaled: 0,
            constant: 1,
            until_update: 1,
            bounded: 0,
            filtered: 0,
            integral: 0,
            timers: [0; 4],
        }
    }

    const fn correction(&self) -> i64 {
        self.filtered + (self.bounded >> 4) + self.integral
    }

    /// Runs until one of the wanted timers rises, or for the whole time. Returns the time used, and the timers that rose.
    pub(crate) fn run(&mut self, clock: u64, wanted: u8) -> (u64, u8) {
        let ticks = (self.prescaled + clock) / self.prescale;
        let mut done = 0;
        let update = self.constant.max(ticks / UPDATES).max(1);
        while done < ticks {
            self.until_update = self.until_update.min(update).max(1);
            let rate = i64::from(self.base) - self.correction();
            let part = (ticks - done).min(self.until_update);
            let (used, events) = self.next(part, rate, wanted);
            let way = i128::from(rate) * i128::from(used);
            let sum = (i128::from(self.accumulator) + way).rem_euclid(i128::from(TURN));
            self.accumulator = i64::try_from(sum).unwrap_or(0);
            done += used;
            self.until_update -= used;
            if self.until_update == 0 {
                self.until_update = update;
                self.filter();
            }
            if events != 0 {
                let clock = done * self.prescale - self.prescaled;
                self.prescaled = 0;
                return (clock, events);
            }
        }
        self.prescaled = (self.prescaled + clock) % self.prescale;
        (clock, 0)
    }

    /// Returns the ticks until a wanted timer rises, at most `part`, and the timers that rise then.
    fn next(&self, part: u64, rate: i64, wanted: u8) -> (u64, u8) {
        let (Ok(speed), true) = (u64::try_from(rate), wanted != 0 && 0 < rate) else {
            return (part, 0);
        };
        let (mut used, mut events) = (part, 0);
        let times = core::iter::once(0).chain(self.timers.iter().copied());
        for (bit, time) in [1_u8, 2, 4, 8, 16].into_iter().zip(times) {
            if wanted & bit == 0 {
                continue;
            }
            let goal = i64::from(0_u16.wrapping_sub(time)) << (WIDTH - 16);
            let mut way = (goal - self.accumulator).rem_euclid(TURN);
            if way == 0 {
                way = TURN;
            }
            let ticks = way.unsigned_abs().div_ceil(speed);
            if ticks < used || ticks == used && events == 0 {
                (used, events) = (ticks, bit);
            } else if ticks == used {
                events |= bit;
            }
        }
        (used, events)
    }

    fn filter(&mut self) {
        self.filtered += (self.bounded >> 8) - (self.filtered >> 8);
        self.integral = bounded(self.integral, LIMIT) + (self.bounded >> 12);
    }

    /// Phase in units of 2^-32 turns, signed.
    fn phase(&self) -> u32 {
        u32::try_from(self.accumulator >> (WIDTH - 32)).unwrap_or(0)
    }

    fn sync(&mut self) {
        let error = i64::from(self.phase().cast_signed() >> 8);
        self.bounded = bounded(error, self.limit);
    }

    pub(crate) fn read(&mut self, register: u8) -> u32 {
        let [one, two, three, four] = self.timers.map(u32::from);
        let [prescale, ..] = self.prescale.to_le_bytes();
        let correction = u32::try_from(self.correction() & 0x00FF_FFFF).unwrap_or(0);
        match register {
            BASE_RATE => self.base.cast_unsigned(),
            PHASE_ERROR => self.phase(),
            CONTROL_0 => u32::from(prescale) << 24 | correction,
            CONTROL_1 => u32::try_from(self.constant & 0xFFFF).unwrap_or(0) << 16 | WIDTH,
            TIMERS_12 => two << 16 | one,
            TIMERS_34 => four << 16 | three,
            SYNC => {
                let phase = self.phase();
                self.sync();
                phase
            }
            _ => 0,
        }
    }

    pub(crate) fn write(&mut self, register: u8, value: u32) {
        let [low_0, low_1, high_0, high_1] = value.to_le_bytes();
        let (low, high) =
            (u16::from_le_bytes([low_0, low_1]), u16::from_le_bytes([high_0, high_1]));
        match register {
            BASE_RATE => self.base = value.cast_signed(),
            PHASE_ERROR => self.accumulator = i64::from(value) << (WIDTH - 32),
            CONTROL_0 => {
                self.limit = i64::from(((value << 8).cast_signed()) >> 8).abs();
                self.prescale = if high_1 == 0 { 256 } else { u64::from(high_1) };
                self.prescaled = 0;
                (self.filtered, self.bounded, self.integral) = (0, 0, 0);
            }
            CONTROL_1 => self.constant = if high == 0 { 1 << 16 } else { u64::from(high) },
            TIMERS_12 => [self.timers[0], self.timers[1]] = [low, high],
            TIMERS_34 => [self.timers[2], self.timers[3]] = [low, high],
            SYNC => self.sync(),
            _ => {}
        }
    }
}

/// Returns a value, at most the limit in either direction.
fn bounded(value: i64, limit: i64) -> i64 {
    value.max(-limit).min(limit)
}
