//! Generators of pulse width.
//!
//! Source: Mesa's `dpwmpdmgenh.vhd`, published under the BSD licence with 3 clauses.

use hal_firmware::registers as r;

/// All generators of a card.
#[derive(Debug)]
pub(crate) struct PulseWidths {
    all: Vec<Width>,
    rate: u32,
    density_rate: u32,
    enabled: u32,
    /// Phase of the reference in units of 2^-16 counts.
    phase: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Width {
    value: u32,
    mode: u32,
}

/// Bits of the reference that all generators share.
const REFERENCE: u32 = 13;

impl PulseWidths {
    pub(crate) fn new(count: usize) -> Self {
        Self { all: vec![Width::default(); count], rate: 0, density_rate: 0, enabled: 0, phase: 0 }
    }

    pub(crate) const fn advance(&mut self, clock: u64) {
        let way = (self.rate & 0xFFFF) as u64;
        self.phase = self.phase.wrapping_add(way.wrapping_mul(clock));
    }

    pub(crate) fn write(&mut self, register: u8, instance: u8, value: u32) {
        const VALUE: u8 = r::PWM_VALUE.index;
        const MODE: u8 = r::PWM_MODE.index;
        const RATE: u8 = r::PWM_RATE.index;
        const PDM_RATE: u8 = r::PWM_PDM_RATE.index;
        const ENABLE: u8 = r::PWM_ENABLE.index;
        let one = self.all.get_mut(usize::from(instance));
        match (register, one) {
            (VALUE, Some(one)) => one.value = value,
            (MODE, Some(one)) => one.mode = value,
            (RATE, _) => self.rate = value,
            (PDM_RATE, _) => self.density_rate = value,
            (ENABLE, _) => self.enabled = value,
            _ => {}
        }
    }

    pub(crate) fn is_enabled(&self, instance: usize) -> bool {
        u32::try_from(instance).is_ok_and(|bit| bit < 32 && self.enabled >> bit & 1 == 1)
    }

    /// Returns the duty of a generator, negative for the other direction.
    pub(crate) fn duty(&self, instance: usize) -> Option<f64> {
        let one = self.all.get(instance)?;
        let parts = if one.has_fraction() { one.value >> 12 & 0xFFFF } else { one.width() << 4 };
        let full = one.full() << 4;
        let duty = f64::from(parts.min(full)) / f64::from(full);
        Some(if one.is_backward() { -duty } else { duty })
    }

    /// Returns the frequency of the pulses in hertz, for a clock.
    pub(crate) fn frequency(&self, instance: usize, clock_hz: u32) -> Option<f64> {
        let one = self.all.get(instance)?;
        let period = f64::from(one.full()) * if one.is_symmetrical() { 2.0 } else { 1.0 };
        Some(f64::from(clock_hz) * f64::from(self.rate & 0xFFFF) / 65536.0 / period)
    }

    pub(crate) fn level(&self, instance: u8, number: u8) -> bool {
        let Some(one) = self.all.get(usize::from(instance)) else { return false };
        let at = self.phase >> 16 & ((1 << REFERENCE) - 1);
        let full = u64::from(one.full());
        let mut place = at & (full - 1);
        if one.is_symmetrical() && at & full != 0 {
            place = full - 1 - place;
        }
        let pulse = place < u64::from(one.width());
        match (number, one.mode >> 3 & 3) {
            (3, _) => !self.is_enabled(usize::from(instance)),
            (1, 0 | 3) | (2, 1) => pulse,
            (2, 0 | 3) | (1, 1) => one.is_backward(),
            (1, 2) => pulse && one.is_backward(),
            (2, 2) => pulse && !one.is_backward(),
            _ => false,
        }
    }
}

impl Width {
    const fn full(&self) -> u32 {
        1 << (9 + (self.mode & 3))
    }

    const fn width(&self) -> u32 {
        self.value >> 16 & 0x0FFF
    }

    /// Returns whether the width has sixteenths, which the card makes by turns of two widths.
    const fn has_fraction(&self) -> bool {
        self.mode & 0x40 != 0
    }

    const fn is_backward(&self) -> bool {
        self.value >> 31 == 1
    }

    const fn is_symmetrical(&self) -> bool {
        self.mode & 4 != 0
    }
}
