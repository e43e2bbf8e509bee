//! Realtime. The shared ring for samples, streams and recordings: one producer, one consumer.
//!
//! A record is a sample number and `width` values. A ring of `depth` slots holds `depth - 1`
//! records. The two sides may be different processes: neither believes an index of the other,
//! and what never changes (depth, width, types) is kept privately, not read back from the ring.
//! Whoever finds an index that cannot be states its own again. A program then follows the engine
//! ([`Producer::follow`], [`Consumer::follow`]), never the other way round: so a ring on which a
//! program scribbled serves the next one.

use core::{
    mem::offset_of,
    sync::atomic::{
        AtomicU64,
        Ordering::{Acquire, Relaxed, Release},
    },
};

/// The most values in a record.
pub const MAX_WIDTH: usize = 21;
/// The first word of every ring ("ferrule" and a version).
pub const RING_MAGIC: u64 = 0x0166_6572_7275_6c65;

/// The head of a ring; `depth * (width + 1)` words follow it.
#[repr(C, align(64))]
#[derive(Debug)]
pub struct Ring {
    /// [`RING_MAGIC`].
    pub magic: u64,
    /// How many slots.
    pub depth: u32,
    /// How many values a record has.
    pub width: u32,
    /// The type code of each value.
    pub types: [u8; 24],
    /// Records lost for want of room.
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
    /// The head of an empty ring.
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

    /// The bytes that a ring of this shape needs.
    pub const fn bytes(depth: u32, width: u32) -> usize {
        size_of::<Self>() + depth as usize * (width as usize + 1) * 8
    }

    /// The index of the next record to be written: how many there have been.
    pub fn written(&self) -> u64 {
        // Pairs with `Producer::put`.
        self.written.load(Acquire)
    }

    /// The index of the next record to be taken, as the reader says.
    pub fn taken(&self) -> u64 {
        // Pairs with `Consumer::take`.
        self.taken.load(Acquire)
    }

    /// Nothing more will be written.
    pub fn close(&self) {
        self.closed.store(1, Release); // Pairs with `is_closed`: what was written before is seen.
    }

    /// Whether nothing more will be written: what waits now is all that there is.
    pub fn is_closed(&self) -> bool {
        self.closed.load(Acquire) != 0 // Pairs with `close`.
    }

    /// How many records wait, never more than the ring can hold.
    pub fn waiting(&self, depth: u32) -> u32 {
        let n = self.written().wrapping_sub(self.taken());
        u32::try_from(n).unwrap_or(u32::MAX).min(depth.saturating_sub(1))
    }
}

/// What both sides know without asking the ring.
#[derive(Debug)]
struct Side {
    ring: *const Ring,
    depth: u32,
    width: u32,
}

impl Side {
    fn head(&self) -> &Ring {
        // SAFETY: live per `Producer::new` and `Consumer::new`.
        unsafe { &*self.ring }
    }

    /// The words of a slot: the number of its record, and its values.
    fn slot(&self, index: u64) -> (&AtomicU64, &[AtomicU64]) {
        let slot = usize::try_from(index % u64::from(self.depth)).unwrap_or(0);
        let width = self.width as usize;
        let at = HEAD_WORDS + slot * (width + 1);
        // SAFETY: the words follow the head, and `slot` is below `depth`.
        let number = unsafe { self.ring.cast::<AtomicU64>().add(at) };
        // SAFETY: as above; each slot has a word more than values.
        let values = unsafe { number.add(1) };
        // SAFETY: live and aligned as above.
        let number = unsafe { &*number };
        // SAFETY: live, aligned, `width` words long as above.
        (number, unsafe { core::slice::from_raw_parts(values, width) })
    }
}

/// The writing side.
#[derive(Debug)]
pub struct Producer {
    side: Side,
    next: u64,
    sample: u64,
}

// SAFETY: one producer; everything shared is atomic.
unsafe impl Send for Producer {}

impl Producer {
    /// The writing side of a ring of this shape.
    ///
    /// # Safety
    /// `ring` heads a live mapping of [`Ring::bytes`] bytes, with no other producer, for as long
    /// as this lives; `depth` and `width` are what it was made with and not zero.
    pub unsafe fn new(ring: *const Ring, depth: u32, width: u32) -> Self {
        let side = Side { ring, depth, width };
        let next = side.head().written.load(Relaxed);
        Self { side, next, sample: next }
    }

    /// Appends a record; `value(i)` gives each value. False when the ring is full (or its other
    /// side wrote nonsense): the record is counted as lost and its number skipped.
    pub fn put(&mut self, value: impl Fn(usize) -> u64) -> bool {
        self.put_all((0..self.side.width as usize).map(value))
    }

    /// As [`Self::put`], with the values in order; they are only asked for when there is room.
    #[inline]
    pub fn put_all(&mut self, values: impl Iterator<Item = u64>) -> bool {
        self.sample = self.sample.wrapping_add(1);
        if self.room() == 0 {
            let lost = self.side.head().lost.load(Relaxed);
            self.side.head().lost.store(lost.wrapping_add(1), Relaxed);
            // As it was, unless somebody scribbled.
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

    /// How many records fit now.
    pub fn room(&self) -> u32 {
        // Pairs with the store in `Consumer::take`.
        let used = self.next.wrapping_sub(self.side.head().taken.load(Acquire));
        let most = u64::from(self.side.depth.saturating_sub(1));
        u32::try_from(most.saturating_sub(used)).unwrap_or(0)
    }

    /// How many records wait.
    pub fn waiting(&self) -> u32 {
        self.side.depth.saturating_sub(1).saturating_sub(self.room())
    }

    /// Goes on from where the reader says it is, if this side's index cannot be.
    pub fn follow(&mut self) {
        let taken = self.side.head().taken.load(Acquire); // Pairs with `Consumer::take`.
        if self.next.wrapping_sub(taken) > u64::from(self.side.depth.saturating_sub(1)) {
            self.next = taken;
            self.side.head().written.store(taken, Release); // Pairs with `Consumer::take`.
        }
    }
}

/// What [`Consumer::take`] found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Got {
    /// A record with this number.
    Sample(u64),
    /// Nothing.
    Nothing,
    /// An index that cannot be: the other side wrote nonsense. Treated as nothing.
    Nonsense,
}

/// The reading side.
#[derive(Debug)]
pub struct Consumer {
    side: Side,
    next: u64,
}

// SAFETY: one consumer; everything shared is atomic.
unsafe impl Send for Consumer {}

impl Consumer {
    /// The reading side of a ring of this shape.
    ///
    /// # Safety
    /// As [`Producer::new`], with no other consumer.
    pub unsafe fn new(ring: *const Ring, depth: u32, width: u32) -> Self {
        let side = Side { ring, depth, width };
        let next = side.head().taken.load(Relaxed);
        Self { side, next }
    }

    /// How many records wait; zero when the other side's index cannot be.
    pub fn waiting(&self) -> u32 {
        // Pairs with the store in `Producer::put`.
        let n = self.side.head().written.load(Acquire).wrapping_sub(self.next);
        let most = u64::from(self.side.depth.saturating_sub(1));
        if n > most { 0 } else { u32::try_from(n).unwrap_or(0) }
    }

    /// Takes the oldest record: `value(i, bits)` receives each value.
    pub fn take(&mut self, mut value: impl FnMut(usize, u64)) -> Got {
        // Pairs with the store in `Producer::put`.
        let n = self.side.head().written.load(Acquire).wrapping_sub(self.next);
        if n == 0 {
            return Got::Nothing;
        }
        if n > u64::from(self.side.depth.saturating_sub(1)) {
            // As it was, unless somebody scribbled.
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

    /// Records that the writer has lost for want of room, and whether it writes no more: what
    /// waits then is all that there is.
    pub fn lost_and_closed(&self) -> (u64, bool) {
        let closed = self.side.head().is_closed();
        (self.side.head().lost.load(Relaxed), closed)
    }

    /// Goes on from where the writer says it is, if this side's index cannot be.
    pub fn follow(&mut self) {
        let written = self.side.head().written.load(Acquire); // Pairs with `Producer::put`.
        if written.wrapping_sub(self.next) > u64::from(self.side.depth.saturating_sub(1)) {
            self.next = written;
            self.side.head().taken.store(written, Release); // Pairs with `Producer::room`.
        }
    }
}
