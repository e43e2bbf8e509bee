//! Realtime. Seqlocks: one writer replaces a record of words, and any number of readers copy it.
//!
//! The sequence number is odd while the writer replaces the words. A reader that finds it odd, or
//! changed after the copy, has no valid copy and tries again. Readers write nothing, so they cannot
//! delay the writer. The words themselves are stored and loaded with `Relaxed`.

use crate::sync::{AtomicU64, Ordering, fence};

/// Begins to replace the words of a record.
///
/// `number` is the writer's own copy of the sequence number, even between two records. The writer
/// never reads the shared one, so that a process that can write the memory cannot mislead it.
#[inline]
pub fn begin(sequence: &AtomicU64, number: u64) {
    sequence.store(number.wrapping_add(1), Ordering::Relaxed);
    // Pairs with the fence in `read`: a reader of a new word finds the sequence number changed.
    fence(Ordering::Release);
}

/// Publishes the words stored since [`begin`].
#[inline]
pub fn end(sequence: &AtomicU64, number: &mut u64) {
    *number = number.wrapping_add(2);
    sequence.store(*number, Ordering::Release); // Pairs with the first load in `read`.
}

/// Calls `copy`, which loads the words, and returns the sequence number of the copy. Returns `None`
/// if the writer was replacing the words: the copy is then invalid, or was not made.
#[inline]
pub fn read(sequence: &AtomicU64, copy: impl FnOnce()) -> Option<u64> {
    let before = sequence.load(Ordering::Acquire); // Pairs with the store in `end`.
    if !before.is_multiple_of(2) {
        return None;
    }
    copy();
    fence(Ordering::Acquire); // Pairs with the fence in `begin`.
    (sequence.load(Ordering::Relaxed) == before).then_some(before)
}
