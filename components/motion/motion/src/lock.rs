//! Realtime. Lock of a joint: an indexer that is clamped except while it moves.

use crate::pins::UnlockPins;

/// State of a joint's lock.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lock {
    /// True if the joint has pins for its lock.
    pub(crate) exists: bool,
    /// Value of the pin `unlock`.
    wanted: bool,
    /// Value of the pin `is-unlocked`.
    pub(crate) is_open: bool,
}

impl Lock {
    pub(crate) const fn new(exists: bool) -> Self {
        Self { exists, wanted: false, is_open: false }
    }

    /// Returns whether the lock holds the joint.
    pub(crate) const fn is_closed(&self) -> bool {
        self.exists && !(self.wanted && self.is_open)
    }

    /// Opens the lock while `needed`; afterwards it stays open while the joint `moves`.
    pub(crate) const fn work(&mut self, needed: bool, moves: bool) {
        self.wanted = needed || (self.wanted && moves);
    }

    pub(crate) fn read_pins(&mut self, pins: &UnlockPins) {
        self.is_open = pins.is_unlocked.get();
    }

    pub(crate) fn write_pins(&self, pins: &UnlockPins) {
        pins.unlock.set(self.wanted);
    }
}
