//! Realtime. What counting and capturing tell each other.

use std::sync::atomic::{
    AtomicBool, AtomicI32, AtomicU32,
    Ordering::{Acquire, Release},
};

/// What counting has noticed since the last capture.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    /// The raw count.
    pub(crate) raw: AtomicI32,
    /// When it last changed, in nanoseconds of the time base.
    pub(crate) at: AtomicU32,
    /// Whether it changed.
    pub(crate) counted: AtomicBool,
    /// The raw count at the index.
    pub(crate) index: AtomicI32,
    /// Whether there was an index.
    pub(crate) indexed: AtomicBool,
    /// The raw count at the latch's edge.
    pub(crate) latch: AtomicI32,
    /// Whether there was such an edge.
    pub(crate) latched: AtomicBool,
}

/// Two notebooks: counting writes in one while the other is read.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    seen: [Seen; 2],
    turn: AtomicU32,
    /// Whether the next index counts.
    pub(crate) armed: AtomicBool,
    /// How long a pause between pulses shows missing teeth, in nanoseconds.
    pub(crate) pause: AtomicI32,
}

impl Notes {
    /// The notebook that counting writes in.
    #[inline]
    pub(crate) fn write(&self) -> &Seen {
        let [a, b] = &self.seen;
        if self.turn.load(Acquire) == 0 { a } else { b } // Pairs with `swap`.
    }

    /// Gives counting the other notebook: the one it wrote in.
    #[inline]
    pub(crate) fn swap(&self) -> &Seen {
        let full = self.write();
        let next = 1 - self.turn.load(Acquire).min(1); // Only this side stores.
        self.turn.store(next, Release); // Pairs with `write`.
        full
    }
}

/// The time of the fast function: how long it has run, in nanoseconds; it wraps after 4.29 s.
#[derive(Debug, Default)]
pub(crate) struct TimeBase(AtomicU32);

impl TimeBase {
    /// Now.
    pub(crate) fn now(&self) -> u32 {
        self.0.load(Acquire) // Pairs with `set`.
    }

    /// Moves on.
    pub(crate) fn set(&self, ns: u32) {
        self.0.store(ns, Release); // Pairs with `now`.
    }
}
