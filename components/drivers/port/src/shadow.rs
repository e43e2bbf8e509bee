//! Realtime. Value last written to a register.

use core::sync::atomic::{
    AtomicU64,
    Ordering::{AcqRel, Acquire},
};

/// Byte last written to a register, shared without a lock by all functions that write it.
///
/// If two threads write at once, the register may hold either byte. A counter that every write changes detects this: a
/// writer that finds it changed meanwhile marks the byte as unknown, and the next write then takes place whatever its
/// value. The shadow is therefore wrong at most until the next write.
#[derive(Debug)]
pub struct Shadow(AtomicU64);

/// Flag: the low eight bits hold the register's value.
const KNOWN: u64 = 1 << 8;
/// Increment of the counter that every write changes.
const STEP: u64 = 1 << 32;

impl Default for Shadow {
    fn default() -> Self {
        Self::new()
    }
}

impl Shadow {
    /// Makes a shadow without a known value.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicU64::new(0))
    }

    /// Returns the byte in the register, if it is known.
    #[must_use]
    pub fn last(&self) -> Option<u8> {
        byte(self.0.load(Acquire)) // Pairs with `put` and `forget`.
    }

    /// Writes `value` through `write` if the register may hold another value. Returns whether it wrote.
    ///
    /// # Errors
    /// The error of `write`; the byte is then unknown.
    pub fn put<E>(&self, value: u8, write: impl FnOnce(u8) -> Result<(), E>) -> Result<bool, E> {
        let before = self.0.load(Acquire); // Pairs with `put` and `forget` of other threads.
        if byte(before) == Some(value) {
            return Ok(false);
        }
        let done = write(value);
        let after = number(before).wrapping_add(STEP) | KNOWN | u64::from(value);
        // Pairs with the loads of other threads: a thread that sees the byte also sees the register's write.
        let alone = self.0.compare_exchange(before, after, AcqRel, Acquire).is_ok();
        if !alone || done.is_err() {
            self.forget();
        }
        done.map(|()| true)
    }

    /// Marks the byte as unknown, so that the next write takes place whatever its value.
    pub fn forget(&self) {
        let unknown = |state| Some(number(state).wrapping_add(STEP));
        // Pairs with the loads of `put`: a `put` in progress sees a new counter. Cannot fail.
        let _ = self.0.fetch_update(AcqRel, Acquire, unknown);
    }
}

const fn number(state: u64) -> u64 {
    state & !(STEP - 1)
}

fn byte(state: u64) -> Option<u8> {
    let [low, ..] = state.to_le_bytes();
    (state & KNOWN != 0).then_some(low)
}

#[cfg(test)]
mod tests {
    use super::Shadow;
    use core::cell::Cell;

    fn ok(_: u8) -> Result<(), ()> {
        Ok(())
    }

    #[test]
    fn writes_first_and_when_changed() {
        let shadow = Shadow::new();
        assert_eq!(shadow.last(), None);
        for (value, written) in [(0, true), (0, false), (0xFF, true), (0xFF, false), (0, true)] {
            assert_eq!(shadow.put(value, ok), Ok(written), "{value}");
            assert_eq!(shadow.last(), Some(value));
        }
        shadow.forget();
        assert_eq!(shadow.last(), None);
        assert_eq!(shadow.put(0, ok), Ok(true));
    }

    #[test]
    fn a_failed_write_is_repeated() {
        let shadow = Shadow::new();
        assert_eq!(shadow.put(1, ok), Ok(true));
        assert_eq!(shadow.put(2, |_| Err("lost")), Err("lost"));
        assert_eq!(shadow.last(), None);
        assert_eq!(shadow.put(1, ok), Ok(true));
    }

    /// Puts `mine` while others put theirs, just before or just after it reaches the register.
    fn cross(before: Option<u8>, mine: u8, others: [u8; 2], late: bool) -> (Cell<u8>, Shadow) {
        let (register, shadow) = (Cell::new(before.unwrap_or(0)), Shadow::new());
        let plain = |v| {
            register.set(v);
            Ok::<_, ()>(())
        };
        if let Some(v) = before {
            shadow.put(v, plain).unwrap();
        }
        let crossed = |v| {
            if late {
                register.set(v);
            }
            for other in others {
                shadow.put(other, plain).unwrap();
            }
            if !late {
                register.set(v);
            }
            Ok::<_, ()>(())
        };
        shadow.put(mine, crossed).unwrap();
        (register, shadow)
    }

    /// The register is right after the next write at the latest, also if others write the byte that is already there.
    #[test]
    fn writes_between_are_noticed() {
        for before in [None, Some(1), Some(2), Some(3)] {
            for case in 0..81_u8 {
                let [mine, a, b, next] = [1, 3, 9, 27].map(|n| case / n % 3 + 1);
                for late in [false, true] {
                    let (register, shadow) = cross(before, mine, [a, b], late);
                    let known = shadow.last();
                    assert!(known.is_none_or(|k| k == register.get()), "{before:?} {case} {late}");
                    let write = |v| {
                        register.set(v);
                        Ok::<_, ()>(())
                    };
                    shadow.put(next, write).unwrap();
                    assert_eq!(register.get(), next, "{before:?} {case} {late}");
                }
            }
        }
    }

    #[test]
    fn forgetting_amid_a_write_counts() {
        let (register, shadow) = (Cell::new(0), Shadow::new());
        let stopped = |v| {
            register.set(v);
            register.set(9);
            shadow.forget();
            Ok::<_, ()>(())
        };
        shadow.put(4, stopped).unwrap();
        assert_eq!(shadow.last(), None);
    }
}
