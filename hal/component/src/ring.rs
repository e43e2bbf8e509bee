//! Realtime. Rings of records in memory, with one writer and one reader. Neither side ever waits
//! for the other.

use crate::sync::{AtomicU64, Ordering};

/// Index in its own cache line: each side writes one and reads the other.
#[derive(Debug)]
#[repr(align(64))]
struct Index(AtomicU64);

/// Slots of equal width, each holding the words of one record.
#[derive(Debug)]
pub(crate) struct Slots {
    words: Box<[AtomicU64]>,
    width: usize,
    depth: u64,
    written: Index,
    taken: Index,
}

impl Slots {
    /// Returns an empty ring over `words`, divided into slots of `width` words, at least one.
    pub(crate) fn over(words: Box<[AtomicU64]>, width: usize) -> Self {
        let depth = (words.len() / width) as u64;
        let index = || Index(AtomicU64::new(0));
        Self { words, width, depth, written: index(), taken: index() }
    }

    fn slot(&self, index: u64) -> &[AtomicU64] {
        let at = usize::try_from(index % self.depth).unwrap_or(0) * self.width;
        self.words.get(at..at + self.width).unwrap_or_default()
    }

    /// Returns the number of records in the ring.
    pub(crate) fn waiting(&self) -> u64 {
        // Pairs with the store in `put`.
        let written = self.written.0.load(Ordering::Acquire);
        // Pairs with the store in `take`.
        written.wrapping_sub(self.taken.0.load(Ordering::Acquire))
    }

    /// Writer: appends a record with these words. Returns false if the ring is full.
    pub(crate) fn put(&self, fill: impl FnOnce(&[AtomicU64])) -> bool {
        let next = self.written.0.load(Ordering::Relaxed);
        // Pairs with the store in `take`: the reader has copied the slot before it is filled again.
        if next.wrapping_sub(self.taken.0.load(Ordering::Acquire)) >= self.depth {
            return false;
        }
        fill(self.slot(next));
        self.written.0.store(next.wrapping_add(1), Ordering::Release); // Pairs with `take`.
        true
    }

    /// Reader: takes the oldest record, if there is one.
    pub(crate) fn take<R>(&self, read: impl FnOnce(&[AtomicU64]) -> R) -> Option<R> {
        let next = self.taken.0.load(Ordering::Relaxed);
        // Pairs with the store in `put`.
        if next == self.written.0.load(Ordering::Acquire) {
            return None;
        }
        let record = read(self.slot(next));
        self.taken.0.store(next.wrapping_add(1), Ordering::Release); // Pairs with `put`.
        Some(record)
    }
}
