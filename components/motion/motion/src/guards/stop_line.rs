//! Realtime. The stop line: stops that are commanded, and the stop epoch by which orders from before them are refused.
//!
//! A stop does not wait behind the commands before it. The command of a stop pulls the line ([`StopLine::pull`]), which
//! raises the epoch at once, and the next cycle of the controller acts on it before it takes any command. Commands from
//! before the stop are still in the queue then, and are refused by their epoch.

use crate::commands::command::{Request, Run};
use hal_component::StopEpoch;
use std::sync::atomic::{
    AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};

/// Stops that the controller has not acted on: bits of [`Stop`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Pulled(u32);

/// A stop that a command asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stop {
    /// The machine is switched off.
    Off = 1,
    /// All motion brakes, and the rest of the path is discarded.
    Abort = 2,
    /// All motion brakes, and the path rests.
    Pause = 4,
}

impl Stop {
    /// Returns the stop that a request is, if it is one.
    pub(crate) const fn of(request: &Request) -> Option<Self> {
        match request {
            Request::Disable => Some(Self::Off),
            Request::Abort => Some(Self::Abort),
            Request::Run(Run::Pause) => Some(Self::Pause),
            _ => None,
        }
    }
}

impl Pulled {
    /// Returns whether nothing was asked for.
    pub(crate) const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// Returns whether this stop was asked for.
    pub(crate) const fn has(self, stop: Stop) -> bool {
        self.0 & stop as u32 != 0
    }
}

/// The stop line, which commands and the controller share.
#[derive(Debug)]
pub(crate) struct StopLine {
    pulled: AtomicU32,
    stops: AtomicU32,
    pauses: AtomicU32,
}

impl Default for StopLine {
    fn default() -> Self {
        Self { pulled: AtomicU32::new(0), stops: AtomicU32::new(1), pauses: AtomicU32::new(0) }
    }
}

impl StopLine {
    /// Returns the epoch.
    pub(crate) fn epoch(&self) -> StopEpoch {
        StopEpoch { stops: self.stops.load(Relaxed), pauses: self.pauses.load(Relaxed) }
    }

    /// Commands a stop: the epoch rises, and the next cycle acts on it.
    pub(crate) fn pull(&self, stop: Stop) {
        self.raise(stop);
        self.pulled.fetch_or(stop as u32, Release); // Pairs with `take`.
    }

    /// Raises the epoch: a stop has come, or motion has stopped by itself.
    pub(crate) fn raise(&self, stop: Stop) {
        if stop == Stop::Pause {
            self.pauses.fetch_add(1, Relaxed);
            return;
        }
        // 0 is the epoch of an order that has none.
        if self.stops.fetch_add(1, Relaxed) == u32::MAX {
            self.stops.fetch_add(1, Relaxed);
        }
    }

    /// Realtime. Takes the stops that were commanded since it was last called.
    pub(crate) fn take(&self) -> Pulled {
        // Most cycles only read.
        if self.pulled.load(Relaxed) == 0 {
            return Pulled::default();
        }
        Pulled(self.pulled.swap(0, Acquire)) // Pairs with `pull`.
    }
}

#[cfg(test)]
mod tests {
    use super::{Stop, StopLine};

    #[test]
    fn a_stop_is_taken_once_and_its_epoch_stays() {
        let line = StopLine::default();
        let first = line.epoch();
        assert!(line.take().is_none());
        line.pull(Stop::Abort);
        line.pull(Stop::Pause);
        let pulled = line.take();
        let has = [Stop::Off, Stop::Abort, Stop::Pause].map(|stop| pulled.has(stop));
        assert_eq!(has, [false, true, true]);
        assert!(line.take().is_none());
        let now = line.epoch();
        assert_eq!((now.stops, now.pauses), (first.stops + 1, first.pauses + 1));
        line.raise(Stop::Off);
        assert!(line.take().is_none(), "motion has stopped by itself");
        assert_eq!(line.epoch().stops, first.stops + 2);
    }

    #[test]
    fn no_epoch_is_0() {
        let line = StopLine::default();
        assert_ne!(line.epoch().number(), 0);
        line.stops.store(u32::MAX, super::Relaxed);
        line.raise(Stop::Abort);
        assert_eq!(line.epoch().stops, 1);
    }
}
