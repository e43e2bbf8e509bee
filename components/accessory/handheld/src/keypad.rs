//! Realtime. Physical and virtual keys together: one frame in every period.

use crate::keys::KeySet;

/// Number of periods for which a virtual key is down, unless its line says otherwise.
pub const DOWN: u32 = 3;
/// Number of periods without a virtual key after each, so that equal keys are distinct.
pub const UP: u32 = 2;
/// Number of periods after which the last good frame of the physical keys no longer counts.
pub const STALE: u32 = 3;

/// Press of a virtual key.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Press {
    /// Number of the key, from 1.
    pub key: u8,
    /// Number of periods for which it is down, at least 1.
    pub periods: u32,
}

impl Press {
    /// Returns a press of the usual length.
    #[must_use]
    pub const fn short(key: u8) -> Self {
        Self { key, periods: DOWN }
    }
}

/// Multiplexer of physical and virtual keys.
#[derive(Clone, Copy, Debug)]
pub struct Keypad {
    physical: KeySet,
    /// Periods since the last good frame.
    age: u32,
    key: u8,
    down: u32,
    up: u32,
}

impl Default for Keypad {
    fn default() -> Self {
        Self { physical: KeySet::NONE, age: STALE, key: 0, down: 0, up: 0 }
    }
}

impl Keypad {
    /// Takes the physical keys of a good frame.
    pub const fn physical(&mut self, keys: KeySet) {
        (self.physical, self.age) = (keys, 0);
    }

    /// Returns whether the physical keys are known.
    #[must_use]
    pub const fn has_physical(&self) -> bool {
        self.age < STALE
    }

    /// Returns whether no virtual key is down, and the time after the last one has passed.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        self.down == 0 && self.up == 0
    }

    /// Returns the virtual key that is down, or was down last and keeps others waiting.
    #[must_use]
    pub const fn virtual_key(&self) -> Option<u8> {
        if self.is_free() { None } else { Some(self.key) }
    }

    /// Releases the virtual key, at once.
    pub const fn release(&mut self) {
        (self.down, self.up) = (0, 0);
    }

    /// Begins a period, and returns its keys: the physical ones, the virtual one, and those that are `held`. `next` gives
    /// the next press that waits.
    pub fn period(&mut self, held: KeySet, next: impl FnOnce() -> Option<Press>) -> KeySet {
        let mut keys = held;
        if self.has_physical() {
            keys = keys.with(self.physical);
        }
        self.age = self.age.saturating_add(1);
        if self.down == 0 && self.up > 0 {
            self.up -= 1;
            return keys;
        }
        if self.down == 0
            && let Some(press) = next()
        {
            (self.key, self.down, self.up) = (press.key, press.periods.max(1), UP);
        }
        if self.down > 0 {
            self.down -= 1;
            keys = keys.with(KeySet::of(self.key));
        }
        keys
    }
}
