//! Step generators.
//!
//! Each adds its rate to an accumulator of 48 bits with each tick; bit 32 and above are counts. A count that would come
//! too early for the lengths of the pulses, or while the direction changes, waits: the accumulator stands still just below
//! it. Source: Mesa's `kubstepgenzd.vhd`, published under the BSD licence with 3 clauses.

use crate::timer::Latched;
use hal_firmware::registers as r;

// Numbers of registers.
const ACCUMULATOR: u8 = r::STEP_ACCUMULATOR.index;
const TIMER: u8 = r::STEP_TIMER.index;
const RATE: u8 = r::STEP_RATE.index;
const MODE: u8 = r::STEP_MODE.index;
const SETUP: u8 = r::STEP_SETUP.index;
const HOLD: u8 = r::STEP_HOLD.index;
const LENGTH: u8 = r::STEP_LENGTH.index;
const SPACE: u8 = r::STEP_SPACE.index;
const TABLE_DATA: u8 = r::STEP_TABLE_DATA.index;
const TABLE_LENGTH: u8 = r::STEP_TABLE_LENGTH.index;
const MASTER_RATE: u8 = r::STEP_MASTER_RATE.index;

/// Bits of the registers of times.
const TIME: u32 = 0x3FFF;
/// Clock periods from a step to the next at least, beyond the pulse's length and space.
const OVERHEAD: u64 = 4;
/// Levels of a table.
const TABLE: usize = 16;

/// All step generators of a card.
#[derive(Debug)]
pub(crate) struct Generators {
    all: Vec<Generator>,
    master_rate: u32,
    master: u64,
    latched: Latched,
}

#[derive(Clone, Copy, Debug)]
struct Generator {
    rate: i32,
    accumulator: u64,
    latch: u32,
    counts: i64,
    emitted: i64,
    is_connected: bool,
    mode: u32,
    setup: u32,
    hold: u32,
    length: u32,
    space: u32,
    is_backward: bool,
    /// Ticks since the last step.
    quiet: u64,
    /// Ticks since the direction changed.
    settled: u64,
    table: [u8; TABLE],
    table_last: u32,
    table_at: u32,
}

impl Generators {
    pub(crate) fn new(count: usize) -> Self {
        let one = Generator {
            rate: 0,
            accumulator: 0,
            latch: 0,
            counts: 0,
            emitted: 0,
            is_connected: false,
            mode: 0,
            setup: 0,
            hold: 0,
            length: 0,
            space: 0,
            is_backward: false,
            quiet: u64::MAX,
            settled: u64::MAX,
            table: [0; TABLE],
            table_last: 0,
            table_at: 0,
        };
        Self {
            all: vec![one; count],
            master_rate: u32::MAX,
            master: 0,
            latched: Latched::default(),
        }
    }

    pub(crate) const fn timers(&self) -> u8 {
        self.latched.timers()
    }

    pub(crate) fn advance(&mut self, clock: u64) {
        let ticks = if self.master_rate == u32::MAX {
            clock
        } else {
            let sum = u128::from(self.master) + u128::from(self.master_rate) * u128::from(clock);
            self.master = u64::try_from(sum & u128::from(u32::MAX)).unwrap_or(0);
            u64::try_from(sum >> 32).unwrap_or(u64::MAX)
        };
        for generator in &mut self.all {
            generator.advance(ticks);
        }
    }

    pub(crate) fn latch(&mut self, events: u8) {
        if self.latched.takes(events) {
            for generator in &mut self.all {
                generator.latch = generator.read();
            }
        }
    }

    pub(crate) fn read(&self, register: u8, instance: u8) -> u32 {
        let Some(one) = self.all.get(usize::from(instance)) else { return 0 };
        match register {
            ACCUMULATOR if self.latched.is_enabled() => one.latch,
            ACCUMULATOR => one.read(),
            TIMER => self.latched.register(),
            _ => 0,
        }
    }

    pub(crate) fn write(&mut self, register: u8, instance: u8, value: u32) {
        match register {
            MASTER_RATE => self.master_rate = value,
            TIMER => self.latched = Latched::from_register(value),
            _ => {
                let Some(one) = self.all.get_mut(usize::from(instance)) else { return };
                match register {
                    RATE => one.rate = value.cast_signed(),
                    ACCUMULATOR => one.accumulator = u64::from(value) << 16,
                    MODE => one.mode = value,
                    SETUP => one.setup = value & TIME,
                    HOLD => one.hold = value & TIME,
                    LENGTH => one.length = value & TIME,
                    SPACE => one.space = value & TIME,
                    TABLE_DATA => {
                        one.table.rotate_right(1);
                        let [level, ..] = value.to_le_bytes();
                        one.table[0] = level;
                    }
                    TABLE_LENGTH => (one.table_last, one.table_at) = (value & 0x0F, 0),
                    _ => {}
                }
            }
        }
    }

    /// Says whether the step output of a generator reaches its terminal.
    pub(crate) fn connect(&mut self, instance: usize, is_connected: bool) {
        if let Some(one) = self.all.get_mut(instance) {
            one.is_connected = is_connected;
        }
    }

    /// Returns the level of an output of a generator: 1 is the step, 2 the direction, or as the table has it.
    pub(crate) fn level(&self, instance: u8, number: u8) -> bool {
        self.all.get(usize::from(instance)).is_some_and(|one| one.level(number))
    }

    /// Returns counts with their fraction.
    pub(crate) fn position(&self, instance: usize) -> Option<f64> {
        let one = self.all.get(instance)?;
        Some(one.counts as f64 + one.fraction() as f64 / UNIT as f64)
    }

    /// Returns the steps that left the card.
    pub(crate) fn emitted(&self, instance: usize) -> Option<i64> {
        self.all.get(instance).map(|one| one.emitted)
    }
}

/// Accumulator of a count.
const UNIT: u64 = 1 << 32;
const BITS: u64 = (1 << 48) - 1;

impl Generator {
    fn read(&self) -> u32 {
        u32::try_from(self.accumulator >> 16 & u64::from(u32::MAX)).unwrap_or(0)
    }

    const fn fraction(&self) -> u64 {
        self.accumulator & (UNIT - 1)
    }

    fn advance(&mut self, ticks: u64) {
        let mut left = ticks;
        while 0 < left {
            // Products below stay within 64 bits.
            let part = left.min(1 << 30);
            self.run(part);
            left -= part;
        }
    }

    fn run(&mut self, ticks: u64) {
        let mut left = ticks;
        let speed = u64::from(self.rate.unsigned_abs());
        let gap = self.gap();
        while 0 < left {
            let turns = self.is_backward != (self.rate < 0);
            // Ticks until the direction changes, and until a step may come.
            let turn = (u64::from(self.hold) + 2).saturating_sub(self.quiet).max(1);
            let setup = u64::from(self.setup) + 1;
            let pause = gap.saturating_sub(self.quiet).max(1);
            let first = if turns {
                pause.max(turn + setup)
            } else {
                pause.max(setup.saturating_sub(self.settled))
            };
            let due = if speed == 0 { u64::MAX } else { self.due(speed) };
            if !turns && first <= due && speed * gap <= UNIT {
                self.glide(left, speed);
                return;
            }
            let at = due.max(first);
            let used = at.min(left);
            if turns && turn <= used {
                self.is_backward = self.rate < 0;
                self.settled = used - turn;
            } else {
                self.settled = self.settled.saturating_add(used);
            }
            self.quiet = self.quiet.saturating_add(used);
            if left < at {
                self.add((due.saturating_sub(1)).min(left) * speed);
                return;
            }
            self.add(due * speed);
            self.step(1);
            self.quiet = 0;
            left -= used;
        }
    }

    /// Returns the ticks from a step to the next at least.
    fn gap(&self) -> u64 {
        let (length, space) = (u64::from(self.length), u64::from(self.space));
        match (length, space) {
            (0, _) => 1,
            (_, 0) => length + OVERHEAD - 1,
            _ => length + space + OVERHEAD,
        }
    }

    /// Returns the tick on which the next count is due, from 1.
    const fn due(&self, speed: u64) -> u64 {
        if self.rate < 0 {
            self.fraction() / speed + 1
        } else {
            (UNIT - self.fraction()).div_ceil(speed)
        }
    }

    /// Lets all counts of a time come when they are due.
    fn glide(&mut self, ticks: u64, speed: u64) {
        let (fraction, way) = (self.fraction(), ticks * speed);
        let (steps, last) = if self.rate < 0 {
            match way.checked_sub(fraction + 1) {
                None => (0, 0),
                Some(beyond) => {
                    let steps = (beyond >> 32) + 1;
                    (steps, (fraction + (steps - 1) * UNIT) / speed.max(1) + 1)
                }
            }
        } else {
            let steps = (fraction + way) >> 32;
            (steps, (steps * UNIT).saturating_sub(fraction).div_ceil(speed.max(1)))
        };
        self.add(way);
        self.settled = self.settled.saturating_add(ticks);
        if steps == 0 {
            self.quiet = self.quiet.saturating_add(ticks);
        } else {
            self.quiet = ticks - last;
            self.step(steps.cast_signed());
        }
    }

    fn add(&mut self, way: u64) {
        let sum = if self.rate < 0 {
            self.accumulator.wrapping_sub(way)
        } else {
            self.accumulator.wrapping_add(way)
        };
        self.accumulator = sum & BITS;
    }

    fn step(&mut self, count: i64) {
        let count = if self.rate < 0 { -count } else { count };
        self.counts = self.counts.wrapping_add(count);
        if self.is_connected {
            self.emitted = self.emitted.wrapping_add(count);
        }
        let length = i64::from(self.table_last) + 1;
        let at = (i64::from(self.table_at) + count).rem_euclid(length);
        self.table_at = u32::try_from(at).unwrap_or(0);
    }

    fn level(&self, number: u8) -> bool {
        let pulse = self.quiet <= u64::from(self.length) + 1;
        let table = usize::try_from(self.table_at).ok().and_then(|at| self.table.get(at));
        let bit = |number: u8| {
            number.checked_sub(1).is_some_and(|bit| table.is_some_and(|t| t >> bit.min(7) & 1 == 1))
        };
        let swapped = self.mode & 4 != 0;
        let number = match number {
            1 if swapped => 2,
            2 if swapped => 1,
            other => other,
        };
        let quarter = self.accumulator >> 30 & 3;
        match (self.mode & 3, number) {
            (0, 1) => pulse,
            (0, 2) => self.is_backward,
            (1, 1) => pulse && !self.is_backward,
            (1, 2) => pulse && self.is_backward,
            (2, 1) => quarter == 1 || quarter == 2,
            (2, 2) => quarter == 2 || quarter == 3,
            _ => bit(number),
        }
    }
}
