//! Realtime. What the slow and the fast function of a channel tell each other.

use core::sync::atomic::{
    AtomicI64, AtomicU32,
    Ordering::{Acquire, Release},
};

/// Fraction bits of an accumulator: one step is `1 << FRACTION`.
pub(crate) const FRACTION: u32 = 28;
/// One step, as an accumulator counts.
pub(crate) const STEP: i64 = 1 << FRACTION;
/// Where an accumulator starts, so that steps fall halfway between two positions.
pub(crate) const HALF: i64 = STEP / 2;
/// The fast function's period as long as it never ran.
pub(crate) const ASSUMED_NS: i64 = 50_000;

/// What the slow function asks of one channel, in accumulator counts per fast period.
#[derive(Debug, Default)]
pub(crate) struct Wanted {
    rate: AtomicI64,
    ramp: AtomicI64,
    stops: AtomicU32,
}

impl Wanted {
    /// Asks for a rate, reached by at most `ramp` per fast period; zero: at once.
    pub(crate) fn ask(&self, rate: i64, ramp: i64) {
        self.ramp.store(ramp, Release); // Pairs with `rate`.
        self.rate.store(rate, Release); // Pairs with `rate`.
    }

    /// Asks for a dead stop.
    pub(crate) fn stop(&self) {
        self.rate.store(0, Release); // Pairs with `rate`.
        let next = self.stops.load(Acquire).wrapping_add(1); // Only this side stores.
        self.stops.store(next, Release); // Pairs with `stops`.
    }

    /// The rate asked for, and the ramp towards it.
    #[inline]
    pub(crate) fn rate(&self) -> (i64, i64) {
        let rate = self.rate.load(Acquire); // Pairs with `ask` and `stop`.
        (rate, self.ramp.load(Acquire)) // Pairs with `ask`.
    }

    /// A number that changes with every dead stop.
    #[inline]
    pub(crate) fn stops(&self) -> u32 {
        self.stops.load(Acquire) // Pairs with `stop`.
    }
}

/// What the fast function has made of one channel.
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
    /// The accumulator.
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

/// The fast function's period.
#[derive(Debug, Default)]
pub(crate) struct Base {
    ns: AtomicI64,
}

impl Base {
    /// In nanoseconds; nothing before the first run.
    pub(crate) fn ns(&self) -> Option<i64> {
        Some(self.ns.load(Acquire)).filter(|ns| *ns > 0) // Pairs with `set`.
    }

    /// Publishes the period.
    pub(crate) fn set(&self, ns: i64) {
        self.ns.store(ns, Release); // Pairs with `ns`.
    }
}

/// Whole steps of an accumulator; the count wraps.
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
