//! Realtime. The byte queue behind signals of type `port`: one writer, one reader.

use core::{
    mem::offset_of,
    sync::atomic::{
        AtomicU8, AtomicU64,
        Ordering::{Acquire, Relaxed, Release},
    },
};

/// A byte queue. A queue of size `n` holds `n - 1` bytes, as users' components expect.
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

// SAFETY: one writer and one reader; all shared fields are atomic.
unsafe impl Sync for PortQueue {}
// SAFETY: as for `Sync`.
unsafe impl Send for PortQueue {}

impl PortQueue {
    /// A queue over `size` bytes at `data`.
    ///
    /// # Safety
    /// The bytes stay live and unshared for as long as the queue is used.
    pub const unsafe fn new(data: *const AtomicU8, size: u64) -> Self {
        Self { size, data, written: AtomicU64::new(0), read: AtomicU64::new(0) }
    }

    /// The size it was made with, in bytes.
    pub const fn size(&self) -> u64 {
        self.size
    }

    /// How many bytes wait to be read.
    pub fn readable(&self) -> u64 {
        // Pairs with the store in `write`.
        self.written.load(Acquire).wrapping_sub(self.read.load(Acquire))
    }

    /// How many bytes fit.
    pub fn writable(&self) -> u64 {
        self.size.saturating_sub(1).saturating_sub(self.readable())
    }

    fn byte(&self, index: u64) -> &AtomicU8 {
        let at = usize::try_from(index % self.size).unwrap_or(0);
        // SAFETY: below `size`.
        let place = unsafe { self.data.add(at) };
        // SAFETY: live per `new`.
        unsafe { &*place }
    }

    /// Appends all of `bytes`, or nothing when they do not fit.
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

    /// Fills `out` without taking the bytes, or does nothing when there are too few.
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

    /// Fills `out` and takes the bytes, or does nothing when there are too few.
    pub fn read(&self, out: &mut [u8]) -> bool {
        if !self.peek(out) {
            return false;
        }
        let next = self.read.load(Relaxed).wrapping_add(out.len() as u64);
        self.read.store(next, Release); // Pairs with the load in `readable`.
        true
    }

    /// Throws away what waits; the reader's call.
    pub fn clear(&self) {
        self.read.store(self.written.load(Acquire), Release); // Pairs with `readable`.
    }
}
