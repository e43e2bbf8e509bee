//! Inputs with filters, and scanned inputs: the same registers over two sources.
//!
//! An input of the field that is on pulls its line down: the controller inverts all lines by bit 5 of the control register.
//!
//! Source: Mesa's `inm.vhd` and `inmuxm.vhd`, published under the BSD licence with 3 clauses.

use hal_firmware::registers as r;

// Numbers of registers.
const CONTROL: u8 = r::INPUTS_CONTROL.index;
const FILTER: u8 = r::INPUTS_FILTER.index;
const FILTERED: u8 = r::INPUTS_FILTERED.index;
const RAW: u8 = r::INPUTS_RAW.index;
const WHEELS: u8 = r::INPUTS_WHEELS.index;

/// Filtered inputs of a module.
#[derive(Debug)]
pub(crate) struct FilteredInputs {
    width: u8,
    control: u32,
    long: u32,
    raw: u32,
    filtered: u32,
    counts: [u32; 32],
    wheels: [u8; 4],
    four: [bool; 4],
    rest: u64,
}

/// Clock periods that the module's prescaler makes of one.
const PRESCALE: u64 = 4;

impl FilteredInputs {
    pub(crate) fn new(width: u8) -> Self {
        let width = width.min(32);
        Self {
            width,
            control: u32::from(width.saturating_sub(1)) & 0x1F,
            long: 0,
            raw: if width < 32 { (1 << width) - 1 } else { u32::MAX },
            filtered: 0,
            counts: [0; 32],
            wheels: [0; 4],
            four: [false; 4],
            rest: 0,
        }
    }

    /// Sets the level of an input's line.
    pub(crate) const fn set(&mut self, input: u8, level: bool) {
        if input < self.width {
            let bit = 1 << input;
            self.raw = if level { self.raw | bit } else { self.raw & !bit };
        }
    }

    pub(crate) const fn level(&self, input: u8) -> bool {
        input < 32 && self.raw >> input & 1 == 1
    }

    pub(crate) fn advance(&mut self, clock: u64) {
        // Each input is sampled once per scan of all.
        let sample = PRESCALE * (u64::from(self.control >> 6 & 0x3FF) + 1);
        let scan = sample * u64::from(self.width.max(1));
        let samples = (self.rest + clock) / scan;
        self.rest = (self.rest + clock) % scan;
        let samples = u32::try_from(samples).unwrap_or(u32::MAX);
        if samples == 0 {
            return;
        }
        let before = self.filtered;
        let (short, long) = (self.control >> 16 & 0x3F, self.control >> 22);
        let levels = self.levels();
        for (bit, count) in self.counts.iter_mut().enumerate().take(usize::from(self.width)) {
            let mask = 1_u32 << bit;
            let limit = if self.long & mask != 0 { long } else { short };
            if levels & mask != 0 {
                *count = count.saturating_add(samples).min(limit);
                if *count == limit {
                    self.filtered |= mask;
                }
            } else {
                *count = count.saturating_sub(samples);
                if *count == 0 {
                    self.filtered &= !mask;
                }
            }
        }
        self.wheels(before);
    }

    const fn levels(&self) -> u32 {
        let all = if self.width < 32 { (1 << self.width) - 1 } else { u32::MAX };
        if self.control & 0x20 != 0 { !self.raw & all } else { self.raw }
    }

    /// Counts the hand wheels on the first eight inputs.
    fn wheels(&mut self, before: u32) {
        for (nth, (wheel, four)) in self.wheels.iter_mut().zip(self.four).enumerate() {
            let lines = |word: u32| {
                let two = word >> (nth * 2) & 3;
                (two & 1 == 1, two & 2 == 2)
            };
            let (was, is) = (lines(before), lines(self.filtered));
            let (a_changed, b_changed) = (was.0 != is.0, was.1 != is.1);
            let step = match (four, a_changed, b_changed) {
                (true, true, false) => (is.0 == is.1).then_some(true).or(Some(false)),
                (true, false, true) => (is.0 != is.1).then_some(true).or(Some(false)),
                (false, true, false) if is.1 => Some(is.0),
                _ => None,
            };
            *wheel = match step {
                Some(true) => wheel.wrapping_add(1),
                Some(false) => wheel.wrapping_sub(1),
                None => *wheel,
            };
        }
    }

    pub(crate) fn read(&self, register: u8) -> u32 {
        match register {
            CONTROL => self.control,
            FILTER => self.long,
            FILTERED => self.filtered,
            RAW => self.levels(),
            WHEELS => u32::from_le_bytes(self.wheels),
            _ => 0,
        }
    }

    pub(crate) fn write(&mut self, register: u8, value: u32) {
        match register {
            CONTROL => self.control = value & !0x1F | self.control & 0x1F,
            FILTER => self.long = value,
            WHEELS => self.four = value.to_le_bytes().map(|byte| byte & 1 == 1),
            _ => {}
        }
    }
}
