//! Realtime. The byte queue of a signal of type `port`, with one writer and one reader.

use core::{
    mem::offset_of,
    sync::atomic::{
        AtomicU8, AtomicU64,
        Ordering::{Acquire, Relaxed, Release},
    },
};

/// A byte queue. A queue of size `n` holds `n - 1` bytes, as existing components expect.
#[repr(C)]
#[derive(Debug)]
pub struct PortQueue {
    size: u64,
    data: *const AtomicU8,
    written: AtomicU64,
    read: AtomicU64,
}

const _: () = assert!(offset_of!(PortQueue, data) == 8);
const _: () = assert!(offset_of!(PortQueue, written) == 16 && offset_of!(PortQueue, read) == 24);

// SAFETY: there is one writer and one reader; all shared fields are atomic.
unsafe impl Sync for PortQueue {}
// SAFETY: as for `Sync`.
unsafe impl Send for PortQueue {}

impl PortQueue {
    /// Returns a queue over `size` bytes at `data`.
    ///
    /// # Safety
    /// The bytes must stay live and must not be used otherwise while the queue is used.
    pub const unsafe fn new(data: *const AtomicU8, size: u64) -> Self {
        Self { size, data, written: AtomicU64::new(0), read: AtomicU64::new(0) }
    }

    /// Returns the size with which the queue was created, in bytes.
    pub const fn size(&self) -> u64 {
        self.size
    }

    /// Returns the number of bytes that can be read.
    pub fn readable(&self) -> u64 {
        // Pairs with the store in `write`.
        self.written.load(Acquire).wrapping_sub(self.read.load(Acquire))
    }

    /// Returns the number of bytes that can be written.
    pub fn writable(&self) -> u64 {
        self.size.saturating_sub(1).saturating_sub(self.readable())
    }

    fn byte(&self, index: u64) -> &AtomicU8 {
        let at = usize::try_from(index % self.size).unwrap_or(0);
        // SAFETY: the index is below `size`.
        let place = unsafe { self.data.add(at) };
        // SAFETY: the caller of `new` guarantees that the bytes are live.
        unsafe { &*place }
    }

    /// Appends all of `bytes`, or nothing if they do not fit. Returns whether they fit.
    pub fn write(&self, bytes: &[u8]) -> bool {
        if (bytes.len() as u64) > self.writable() {
            return false;
        }
        let start = self.written.load(Relaxed);
        for (i, b) in bytes.iter().enumerate() {
            self.byte(start.wrapping_add(i as u64)).store(*b, Relaxed);
        }
        // Pairs with the load in `readable`.
        self.written.store(start.wrapping_add(bytes.len() as u64), Release);
        true
    }

    /// Fills `out` without consuming the bytes, or does nothing if there are too few. Returns
    /// whether there were enough.
    pub fn peek(&self, out: &mut [u8]) -> bool {
        if (out.len() as u64) > self.readable() {
            return false;
        }
        let start = self.read.load(Relaxed);
        for (i, b) in out.iter_mut().enumerate() {
            *b = self.byte(start.wrapping_add(i as u64)).load(Relaxed);
        }
        true
    }

    /// Fills `out` and consumes the bytes, or does nothing if there are too few. Returns whether
    /// there were enough.
    pub fn read(&self, out: &mut [u8]) -> bool {
        if !self.peek(out) {
            return false;
        }
        let next = self.read.load(Relaxed).wrapping_add(out.len() as u64);
        self.read.store(next, Release); // Pairs with the load in `readable`.
        true
    }

    /// Discards all unread bytes. Only the reader may call this.
    pub fn clear(&self) {
        self.read.store(self.written.load(Acquire), Release); // Pairs with `readable`.
    }
}
