//! Realtime. Data that the slow and the fast function of a channel exchange.

use core::sync::atomic::{
    AtomicI64, AtomicU32,
    Ordering::{Acquire, Release},
};

/// Number of fraction bits of an accumulator: one step is `1 << FRACTION`.
pub(crate) const FRACTION: u32 = 28;
/// Accumulator counts per step.
pub(crate) const STEP: i64 = 1 << FRACTION;
/// Initial value of an accumulator, so that steps fall halfway between two positions.
pub(crate) const HALF: i64 = STEP / 2;
/// Period assumed until the fast function has run, in nanoseconds.
pub(crate) const ASSUMED_NS: i64 = 50_000;

/// Rate that the slow function requests for one channel, in accumulator counts per fast period.
#[derive(Debug, Default)]
pub(crate) struct Wanted {
    rate: AtomicI64,
    ramp: AtomicI64,
    stops: AtomicU32,
}

impl Wanted {
    /// Requests a rate, reached with at most `ramp` per fast period; a `ramp` of zero means at once.
    pub(crate) fn ask(&self, rate: i64, ramp: i64) {
        self.ramp.store(ramp, Release); // Pairs with `rate`.
        self.rate.store(rate, Release); // Pairs with `rate`.
    }

    /// Requests an immediate stop.
    pub(crate) fn stop(&self) {
        self.rate.store(0, Release); // Pairs with `rate`.
        let next = self.stops.load(Acquire).wrapping_add(1); // Only this side stores.
        self.stops.store(next, Release); // Pairs with `stops`.
    }

    /// Returns the requested rate and its ramp.
    #[inline]
    pub(crate) fn rate(&self) -> (i64, i64) {
        let rate = self.rate.load(Acquire); // Pairs with `ask` and `stop`.
        (rate, self.ramp.load(Acquire)) // Pairs with `ask`.
    }

    /// Returns a number that changes with every immediate stop.
    #[inline]
    pub(crate) fn stops(&self) -> u32 {
        self.stops.load(Acquire) // Pairs with `stop`.
    }
}

/// Output of the fast function for one channel.
#[derive(Debug)]
pub(crate) struct Made {
    accum: AtomicI64,
}

impl Default for Made {
    fn default() -> Self {
        Self { accum: AtomicI64::new(HALF) }
    }
}

impl Made {
    /// Returns the accumulator.
    #[inline]
    pub(crate) fn accum(&self) -> i64 {
        self.accum.load(Acquire) // Pairs with `set`.
    }

    /// Publishes the accumulator.
    #[inline]
    pub(crate) fn set(&self, accum: i64) {
        self.accum.store(accum, Release); // Pairs with `accum`.
    }
}

/// Period of the fast function.
#[derive(Debug, Default)]
pub(crate) struct Base {
    ns: AtomicI64,
}

impl Base {
    /// Returns the period in nanoseconds; `None` before the first cycle.
    pub(crate) fn ns(&self) -> Option<i64> {
        Some(self.ns.load(Acquire)).filter(|ns| *ns > 0) // Pairs with `set`.
    }

    /// Publishes the period.
    pub(crate) fn set(&self, ns: i64) {
        self.ns.store(ns, Release); // Pairs with `ns`.
    }
}

/// Converts an accumulator to whole steps; the count wraps.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "counts wrap")]
pub(crate) const fn steps(accum: i64) -> i32 {
    (accum >> FRACTION) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_wrap() {
        for (accum, count) in [
            (HALF, 0),
            (STEP - 1, 0),
            (STEP, 1),
            (-1, -1),
            (i64::from(i32::MAX) * STEP + HALF, i32::MAX),
            (i64::from(i32::MAX) * STEP + STEP, i32::MIN),
            (i64::MAX, -1),
            (i64::MIN, 0),
        ] {
            assert_eq!(steps(accum), count, "{accum}");
        }
    }

    #[test]
    fn every_stop_is_seen() {
        let wanted = Wanted::default();
        wanted.ask(5, 3);
        assert_eq!((wanted.rate(), wanted.stops()), ((5, 3), 0));
        wanted.stop();
        wanted.ask(7, 3);
        assert_eq!((wanted.rate(), wanted.stops()), ((7, 3), 1));
    }
}
