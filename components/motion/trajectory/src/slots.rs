//! Realtime. Slots of words that one thread writes and another reads, without locks.
//!
//! The writer fills slots in the order of their numbers and raises `count`. It fills a slot again only when the reader has
//! reported that it no longer uses the old number or any lower one. Single words of slots that the reader may see can be raised
//! meanwhile; the writer raises later slots first, so that a reader that sees a raised word sees all after it raised.

use crate::sync::{AtomicU64, Ordering};

/// Direction for which the reader has permission.
const FORWARD: u64 = 0;
const ASKED: u64 = 1;
const GRANTED: u64 = 2;

/// State that both sides share about the order of slots.
#[derive(Debug)]
pub(crate) struct Order {
    count: AtomicU64,
    first: AtomicU64,
    oldest: AtomicU64,
    reverse: AtomicU64,
}

impl Order {
    pub(crate) fn new() -> Self {
        Self {
            count: AtomicU64::new(0),
            first: AtomicU64::new(0),
            oldest: AtomicU64::new(0),
            reverse: AtomicU64::new(FORWARD),
        }
    }

    /// Returns the number of slots that are filled.
    pub(crate) fn count(&self) -> u64 {
        self.count.load(Ordering::Acquire) // Pairs with Release in `publish`.
    }

    /// Writer: shows all slots below this number.
    pub(crate) fn publish(&self, count: u64) {
        self.count.store(count, Ordering::Release); // Pairs with Acquire in `count`.
    }

    /// Returns the number of the first slot that is kept.
    pub(crate) fn first(&self) -> u64 {
        self.first.load(Ordering::Acquire) // Pairs with Release in `give_up`.
    }

    /// Writer: gives up all slots below this number.
    pub(crate) fn give_up(&self, first: u64) {
        self.first.store(first, Ordering::Release); // Pairs with Acquire in `first`.
    }

    /// Reader: promises to use no slot below this number again.
    pub(crate) fn release(&self, oldest: u64) {
        self.oldest.store(oldest, Ordering::Release); // Pairs with Acquire in `oldest`.
    }

    /// Writer: returns the oldest number in use.
    pub(crate) fn oldest(&self) -> u64 {
        self.oldest.load(Ordering::Acquire) // Pairs with Release in `release`.
    }

    /// Reader, at rest: asks to move backward, and returns true once the writer has agreed.
    pub(crate) fn may_turn(&self, reverse: bool) -> bool {
        // Pairs with Release in `settle`.
        let now = self.reverse.load(Ordering::Acquire);
        if !reverse {
            // Pairs with Acquire in `settle`.
            self.reverse.store(FORWARD, Ordering::Release);
            return true;
        }
        if now == FORWARD {
            // Pairs with Acquire in `settle`.
            self.reverse.store(ASKED, Ordering::Release);
        }
        now == GRANTED
    }

    /// Writer: agrees to reverse motion if the reader has asked, and returns true while old slots may be dropped.
    pub(crate) fn settle(&self) -> bool {
        // Pairs with Release in `may_turn`.
        let now = self.reverse.load(Ordering::Acquire);
        if now == ASKED {
            // If the reader has turned forward again meanwhile, that stays. Pairs with Acquire in `may_turn`.
            let _ =
                self.reverse.compare_exchange(ASKED, GRANTED, Ordering::AcqRel, Ordering::Relaxed);
        }
        now == FORWARD
    }
}

/// Slots of `N` words each.
#[derive(Debug)]
pub(crate) struct Slots<const N: usize> {
    words: Box<[[AtomicU64; N]]>,
}

impl<const N: usize> Slots<N> {
    /// Makes at least this number of slots: a power of two, so that no division finds the slot of a number.
    pub(crate) fn new(count: usize) -> Self {
        let count = count.next_power_of_two();
        Self { words: (0..count).map(|_| [0; N].map(AtomicU64::new)).collect() }
    }

    /// Number of slots.
    pub(crate) const fn len(&self) -> u64 {
        self.words.len() as u64
    }

    fn slot(&self, number: u64) -> Option<&[AtomicU64; N]> {
        let k = number & self.len().wrapping_sub(1);
        self.words.get(usize::try_from(k).ok()?)
    }

    /// Writer: fills the slot of a number that is not published yet.
    pub(crate) fn fill(&self, number: u64, words: &[u64; N]) {
        for (slot, word) in self.slot(number).into_iter().flatten().zip(words) {
            slot.store(*word, Ordering::Relaxed); // `Order::publish` orders it.
        }
    }

    /// Writer: replaces a word of a slot that the reader may see.
    pub(crate) fn set(&self, number: u64, word: usize, value: u64) {
        if let Some(slot) = self.slot(number).and_then(|s| s.get(word)) {
            slot.store(value, Ordering::Release); // Pairs with Acquire in `get`.
        }
    }

    /// Reader: returns the words of a published slot; the word `FIRST`, which the writer may raise, is loaded before all
    /// others.
    #[inline]
    pub(crate) fn read<const FIRST: usize>(&self, number: u64) -> Option<[u64; N]> {
        let slot = self.slot(number)?;
        // Pairs with Release in `set`.
        let first = slot.get(FIRST)?.load(Ordering::Acquire);
        // Ordered by `Order::count`.
        let mut words = slot.each_ref().map(|word| word.load(Ordering::Relaxed));
        *words.get_mut(FIRST)? = first;
        Some(words)
    }

    /// Reader: returns the words of a published slot, each loaded when it is taken.
    pub(crate) fn words(&self, number: u64) -> impl Iterator<Item = u64> {
        // Ordered by `Order::count`.
        self.slot(number).into_iter().flatten().map(|word| word.load(Ordering::Relaxed))
    }
}
