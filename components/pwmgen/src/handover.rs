//! Realtime. What the slow and the fast function of a channel tell each other.

use std::sync::atomic::{
    AtomicI64, AtomicU8,
    Ordering::{Acquire, Release},
};

/// The fast function's period as long as it never ran.
pub(crate) const ASSUMED_NS: i64 = 50_000;

/// How pulses are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Not at all.
    Off,
    /// Whole runs per period, the same in each.
    Pure,
    /// A width between two whole ones, on average.
    Dither,
    /// No period: the density of the pulses is what counts.
    Density,
}

/// What a channel is to do.
#[derive(Debug, Default)]
pub(crate) struct Wanted {
    mode: AtomicU8,
    period: AtomicI64,
    high: AtomicI64,
    down: AtomicU8,
}

impl Wanted {
    /// The mode, and the length of a period, in nanoseconds.
    pub(crate) fn ask(&self, mode: Mode, period: i64) {
        self.period.store(period, Release); // Pairs with `get`.
        self.mode.store(mode as u8, Release); // Pairs with `get`.
    }

    /// How long the output is to be true in a period, in nanoseconds, and whether backward.
    pub(crate) fn width(&self, high: i64, down: bool) {
        self.high.store(high, Release); // Pairs with `get`.
        self.down.store(u8::from(down), Release); // Pairs with `get`.
    }

    /// The mode, the period, the width, and whether backward.
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

/// The fast function's period.
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
