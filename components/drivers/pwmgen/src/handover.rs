//! Realtime. Data that the slow and the fast function of a channel exchange.

use std::sync::atomic::{
    AtomicI64, AtomicU8,
    Ordering::{Acquire, Release},
};

/// Period assumed until the fast function has run, in nanoseconds.
pub(crate) const ASSUMED_NS: i64 = 50_000;

/// Method of pulse generation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// No pulses.
    Off,
    /// Whole thread cycles per PWM period, the same in each period.
    Pure,
    /// Average width between two whole numbers of thread cycles.
    Dither,
    /// Pulse-density modulation, without a period.
    Density,
}

/// Requested output of a channel.
#[derive(Debug, Default)]
pub(crate) struct Wanted {
    mode: AtomicU8,
    period: AtomicI64,
    high: AtomicI64,
    down: AtomicU8,
}

impl Wanted {
    /// Requests a mode and a period, in nanoseconds.
    pub(crate) fn ask(&self, mode: Mode, period: i64) {
        self.period.store(period, Release); // Pairs with `get`.
        self.mode.store(mode as u8, Release); // Pairs with `get`.
    }

    /// Requests the high time per period, in nanoseconds, and the direction.
    pub(crate) fn width(&self, high: i64, down: bool) {
        self.high.store(high, Release); // Pairs with `get`.
        self.down.store(u8::from(down), Release); // Pairs with `get`.
    }

    /// Returns the mode, the period, the high time, and true for backward.
    pub(crate) fn get(&self) -> (Mode, i64, i64, bool) {
        let mode = match self.mode.load(Acquire) {
            1 => Mode::Pure,
            2 => Mode::Dither,
            3 => Mode::Density,
            _ => Mode::Off,
        };
        // All pair with `ask` and `width`.
        (mode, self.period.load(Acquire), self.high.load(Acquire), self.down.load(Acquire) != 0)
    }
}

/// Period of the fast function.
#[derive(Debug)]
pub(crate) struct Base(AtomicI64);

impl Default for Base {
    fn default() -> Self {
        Self(AtomicI64::new(ASSUMED_NS))
    }
}

impl Base {
    pub(crate) fn ns(&self) -> i64 {
        self.0.load(Acquire) // Pairs with `set`.
    }

    pub(crate) fn set(&self, ns: i64) {
        self.0.store(ns, Release); // Pairs with `ns`.
    }
}
