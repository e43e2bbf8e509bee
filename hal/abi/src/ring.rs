//! Realtime. The shared ring buffer for samples, streams and recordings, with one producer and one
//! consumer.
//!
//! A record is a sample number and `width` values. A ring of `depth` slots holds `depth - 1`
//! records. The two sides may be different processes. Neither side trusts an index of the other,
//! and values that never change (depth, width, types) are kept privately and not read back from the
//! ring. A side that reads an out-of-range index publishes its own index again. A program can then
//! follow the engine ([`Producer::follow`], [`Consumer::follow`]), but the engine never follows a
//! program. A ring that a program has corrupted therefore still works for the next program.

use core::{
    mem::offset_of,
    sync::atomic::{
        AtomicU64,
        Ordering::{Acquire, Relaxed, Release},
    },
};

/// Maximum number of values in a record.
pub const MAX_WIDTH: usize = 21;
/// First word of every ring ("ferrule" and a version).
pub const RING_MAGIC: u64 = 0x0166_6572_7275_6c65;

/// Header of a ring, followed by `depth * (width + 1)` words.
#[repr(C, align(64))]
#[derive(Debug)]
pub struct Ring {
    /// Always [`RING_MAGIC`].
    pub magic: u64,
    /// Number of slots.
    pub depth: u32,
    /// Number of values in a record.
    pub width: u32,
    /// Type code of each value.
    pub types: [u8; 24],
    /// Number of records lost because the ring was full.
    pub lost: AtomicU64,
    closed: AtomicU64,
    apart: u64,
    written: AtomicU64,
    apart_too: [u64; 7],
    taken: AtomicU64,
    apart_again: [u64; 7],
}

const _: () = assert!(size_of::<Ring>() == 192);
const _: () = assert!(offset_of!(Ring, written) == 64 && offset_of!(Ring, taken) == 128);
const HEAD_WORDS: usize = size_of::<Ring>() / 8;

impl Ring {
    /// Returns the header of an empty ring.
    pub const fn new(depth: u32, width: u32, types: [u8; 24]) -> Self {
        Self {
            magic: RING_MAGIC,
            depth,
            width,
            types,
            lost: AtomicU64::new(0),
            closed: AtomicU64::new(0),
            apart: 0,
            written: AtomicU64::new(0),
            apart_too: [0; 7],
            taken: AtomicU64::new(0),
            apart_again: [0; 7],
        }
    }

    /// Returns the number of bytes that a ring of this shape needs.
    pub const fn bytes(depth: u32, width: u32) -> usize {
        size_of::<Self>() + depth as usize * (width as usize + 1) * 8
    }

    /// Returns the index of the next record to be written, which is the number of records written
    /// so far.
    pub fn written(&self) -> u64 {
        // Pairs with `Producer::put`.
        self.written.load(Acquire)
    }

    /// Returns the index of the next record to be taken, as the reader published it.
    pub fn taken(&self) -> u64 {
        // Pairs with `Consumer::take`.
        self.taken.load(Acquire)
    }

    /// Marks the end of the data: the producer will write no more records.
    pub fn close(&self) {
        self.closed.store(1, Release); // Pairs with `is_closed`: what was written before is seen.
    }

    /// Takes [`Self::close`] back: the next program may have been preceded by one that scribbled.
    pub fn reopen(&self) {
        self.closed.store(0, Release); // Pairs with `is_closed`.
    }

    /// Returns whether the producer will write no more records. Those waiting now are the last
    /// ones.
    pub fn is_closed(&self) -> bool {
        self.closed.load(Acquire) != 0 // Pairs with `close`.
    }

    /// Returns the number of waiting records, limited to what the ring can hold.
    pub fn waiting(&self, depth: u32) -> u32 {
        let n = self.written().wrapping_sub(self.taken());
        u32::try_from(n).unwrap_or(u32::MAX).min(depth.saturating_sub(1))
    }
}

/// Private copy of the ring's shape, which each side keeps.
#[derive(Debug)]
struct Side {
    ring: *const Ring,
    depth: u32,
    width: u32,
}

impl Side {
    fn head(&self) -> &Ring {
        // SAFETY: the callers of `Producer::new` and `Consumer::new` guarantee that the ring is
        // live.
        unsafe { &*self.ring }
    }

    /// Returns the words of a slot: the number of its record, and its values.
    fn slot(&self, index: u64) -> (&AtomicU64, &[AtomicU64]) {
        let slot = usize::try_from(index % u64::from(self.depth)).unwrap_or(0);
        let width = self.width as usize;
        let at = HEAD_WORDS + slot * (width + 1);
        // SAFETY: the words follow the header, and `slot` is below `depth`.
        let number = unsafe { self.ring.cast::<AtomicU64>().add(at) };
        // SAFETY: as above; each slot has one word more than it has values.
        let values = unsafe { number.add(1) };
        // SAFETY: live and aligned as above.
        let number = unsafe { &*number };
        // SAFETY: live, aligned, `width` words long as above.
        (number, unsafe { core::slice::from_raw_parts(values, width) })
    }
}

/// Writing side of a ring.
#[derive(Debug)]
pub struct Producer {
    side: Side,
    next: u64,
    sample: u64,
}

// SAFETY: there is one producer, and everything shared is atomic.
unsafe impl Send for Producer {}

impl Producer {
    /// Returns the writing side of a ring of this shape.
    ///
    /// # Safety
    /// `ring` must be the header of a live mapping of [`Ring::bytes`] bytes without another
    /// producer, for as long as this value lives. `depth` and `width` must be those of the ring and
    /// not zero.
    pub unsafe fn new(ring: *const Ring, depth: u32, width: u32) -> Self {
        let side = Side { ring, depth, width };
        let next = side.head().written.load(Relaxed);
        Self { side, next, sample: next }
    }

    /// Appends a record; `value(i)` returns each value. Returns false if the ring is full (or the
    /// other side published an invalid index). The record is then counted as lost and its number is
    /// skipped.
    pub fn put(&mut self, value: impl Fn(usize) -> u64) -> bool {
        self.put_all((0..self.side.width as usize).map(value))
    }

    /// As [`Self::put`], with the values in order. The iterator is used only if there is space.
    #[inline]
    pub fn put_all(&mut self, values: impl Iterator<Item = u64>) -> bool {
        self.sample = self.sample.wrapping_add(1);
        if self.room() == 0 {
            let lost = self.side.head().lost.load(Relaxed);
            self.side.head().lost.store(lost.wrapping_add(1), Relaxed);
            // Publish the same index again, in case a program has overwritten it.
            self.side.head().written.store(self.next, Release); // Pairs with `Consumer::take`.
            return false;
        }
        let (number, words) = self.side.slot(self.next);
        number.store(self.sample, Relaxed);
        for (word, value) in words.iter().zip(values) {
            word.store(value, Relaxed);
        }
        self.next = self.next.wrapping_add(1);
        self.side.head().written.store(self.next, Release); // Pairs with `Consumer::take`.
        true
    }

    /// Returns whether the ring is closed: nobody takes records any more.
    pub fn is_closed(&self) -> bool {
        self.side.head().is_closed()
    }

    /// Returns the number of records that fit now.
    pub fn room(&self) -> u32 {
        // Pairs with the store in `Consumer::take`.
        let used = self.next.wrapping_sub(self.side.head().taken.load(Acquire));
        let most = u64::from(self.side.depth.saturating_sub(1));
        u32::try_from(most.saturating_sub(used)).unwrap_or(0)
    }

    /// Returns the number of waiting records.
    pub fn waiting(&self) -> u32 {
        self.side.depth.saturating_sub(1).saturating_sub(self.room())
    }

    /// Continues at the reader's index, if this side's index is invalid relative to it.
    pub fn follow(&mut self) {
        let taken = self.side.head().taken.load(Acquire); // Pairs with `Consumer::take`.
        if self.next.wrapping_sub(taken) > u64::from(self.side.depth.saturating_sub(1)) {
            self.next = taken;
            self.side.head().written.store(taken, Release); // Pairs with `Consumer::take`.
        }
    }
}

/// Result of [`Consumer::take`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Got {
    /// A record with this number.
    Sample(u64),
    /// The ring is empty.
    Nothing,
    /// The other side published an invalid index. Treat this like an empty ring.
    Nonsense,
}

/// Reading side of a ring.
#[derive(Debug)]
pub struct Consumer {
    side: Side,
    next: u64,
}

// SAFETY: there is one consumer, and everything shared is atomic.
unsafe impl Send for Consumer {}

impl Consumer {
    /// Returns the reading side of a ring of this shape.
    ///
    /// # Safety
    /// As [`Producer::new`], without another consumer.
    pub unsafe fn new(ring: *const Ring, depth: u32, width: u32) -> Self {
        let side = Side { ring, depth, width };
        let next = side.head().taken.load(Relaxed);
        Self { side, next }
    }

    /// Returns the number of waiting records, or zero if the other side's index is invalid.
    pub fn waiting(&self) -> u32 {
        // Pairs with the store in `Producer::put`.
        let n = self.side.head().written.load(Acquire).wrapping_sub(self.next);
        let most = u64::from(self.side.depth.saturating_sub(1));
        if n > most { 0 } else { u32::try_from(n).unwrap_or(0) }
    }

    /// Takes the oldest record. Calls `value(i, bits)` for each value.
    pub fn take(&mut self, mut value: impl FnMut(usize, u64)) -> Got {
        // Pairs with the store in `Producer::put`.
        let n = self.side.head().written.load(Acquire).wrapping_sub(self.next);
        if n == 0 {
            return Got::Nothing;
        }
        if n > u64::from(self.side.depth.saturating_sub(1)) {
            // Publish the same index again, in case a program has overwritten it.
            self.side.head().taken.store(self.next, Release); // Pairs with `Producer::room`.
            return Got::Nonsense;
        }
        let (number, words) = self.side.slot(self.next);
        let sample = number.load(Relaxed);
        for (i, word) in words.iter().enumerate() {
            value(i, word.load(Relaxed));
        }
        self.next = self.next.wrapping_add(1);
        self.side.head().taken.store(self.next, Release); // Pairs with `Producer::room`.
        Got::Sample(sample)
    }

    /// Returns the number of records that the writer lost because the ring was full, and whether
    /// the ring is closed. Records waiting in a closed ring are the last ones.
    pub fn lost_and_closed(&self) -> (u64, bool) {
        let closed = self.side.head().is_closed();
        (self.side.head().lost.load(Relaxed), closed)
    }

    /// Continues at the writer's index, if this side's index is invalid relative to it.
    pub fn follow(&mut self) {
        let written = self.side.head().written.load(Acquire); // Pairs with `Producer::put`.
        if written.wrapping_sub(self.next) > u64::from(self.side.depth.saturating_sub(1)) {
            self.next = written;
            self.side.head().taken.store(written, Release); // Pairs with `Producer::room`.
        }
    }
}
