//! Realtime. Sets of keys, and the names of the NK105's keys.

/// Largest number of a key.
pub const MOST_KEYS: u8 = 48;

/// Number of the key STOP.
pub const STOP: u8 = 14;

/// Names of the keys of an NK105's handheld, in the order of their numbers from 1.
pub const NAMES: [&str; 29] = [
    "1", "2", "3", "4", "5", "6", "7", "8", "9", "0", ".", "-", "OK", "STOP", "X+", "X-", "Y+",
    "Y-", "Z+", "Z-", "RUN", "ORIGIN", "HOME", "MODE", "UP", "DOWN", "SPINDLE", "HIGH", "SHIFT",
];

/// Returns the number of a key by its name, in capitals or not.
#[must_use]
pub fn number_of(name: &str) -> Option<u8> {
    let at = NAMES.iter().position(|known| known.eq_ignore_ascii_case(name))?;
    u8::try_from(at + 1).ok()
}

/// Set of pressed keys, 1 to 48.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct KeySet(u64);

impl KeySet {
    /// No key.
    pub const NONE: Self = Self(0);

    /// Returns the set of one key; a number outside 1 to 48 gives the empty set.
    #[must_use]
    pub const fn of(key: u8) -> Self {
        if key == 0 || key > MOST_KEYS { Self::NONE } else { Self(1 << (key - 1)) }
    }

    /// Returns whether a key is in the set.
    #[must_use]
    pub const fn has(self, key: u8) -> bool {
        self.0 & Self::of(key).0 != 0
    }

    /// Returns the keys of both sets.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns the keys of this set that are not in the other.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Returns the keys of this set that are in the other, too.
    #[must_use]
    pub const fn within(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Returns whether the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the numbers of the keys, in ascending order.
    pub fn numbers(self) -> impl Iterator<Item = u8> {
        (1..=MOST_KEYS).filter(move |key| self.has(*key))
    }
}
