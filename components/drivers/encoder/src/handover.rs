//! Realtime. Data that counting and capturing exchange.

use std::sync::atomic::{
    AtomicBool, AtomicI32, AtomicU32,
    Ordering::{Acquire, Release},
};

/// Events since the last capture.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    /// Raw count.
    pub(crate) raw: AtomicI32,
    /// Time of its last change, in nanoseconds of the time base.
    pub(crate) at: AtomicU32,
    /// True if the raw count changed.
    pub(crate) counted: AtomicBool,
    /// Raw count at the index.
    pub(crate) index: AtomicI32,
    /// True if there was an index.
    pub(crate) indexed: AtomicBool,
    /// Raw count at the latch edge.
    pub(crate) latch: AtomicI32,
    /// True if there was a latch edge.
    pub(crate) latched: AtomicBool,
}

/// Double buffer: counting writes to one half while capturing reads the other.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    seen: [Seen; 2],
    turn: AtomicU32,
    /// True if the next index counts.
    pub(crate) armed: AtomicBool,
    /// Pause between pulses that indicates missing teeth, in nanoseconds.
    pub(crate) pause: AtomicI32,
}

impl Notes {
    /// Returns the half that counting writes to.
    #[inline]
    pub(crate) fn write(&self) -> &Seen {
        let [a, b] = &self.seen;
        if self.turn.load(Acquire) == 0 { a } else { b } // Pairs with `swap`.
    }

    /// Switches counting to the other half. Returns the half it has written to.
    #[inline]
    pub(crate) fn swap(&self) -> &Seen {
        let full = self.write();
        let next = 1 - self.turn.load(Acquire).min(1); // Only this side stores.
        self.turn.store(next, Release); // Pairs with `write`.
        full
    }
}

/// Total run time of the fast function, in nanoseconds; it wraps after 4.29 s.
#[derive(Debug, Default)]
pub(crate) struct TimeBase(AtomicU32);

impl TimeBase {
    /// Returns the present time.
    pub(crate) fn now(&self) -> u32 {
        self.0.load(Acquire) // Pairs with `set`.
    }

    /// Sets the time.
    pub(crate) fn set(&self, ns: u32) {
        self.0.store(ns, Release); // Pairs with `now`.
    }
}
