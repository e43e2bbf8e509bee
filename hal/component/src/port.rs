//! Realtime. Value of a pin of type `port`.

use crate::{Value, abi};
use core::ptr::NonNull;

/// Byte queue that a pin of type `port` is linked to, if there is one.
///
/// One pin of a signal writes and one reads. The queue lives as long as its signal.
#[derive(Clone, Copy, Debug, Default)]
pub struct Port(Option<NonNull<abi::PortQueue>>);

// SAFETY: a `PortQueue` is accessed only through atomics.
unsafe impl Send for Port {}

impl Value for Port {
    const TYPE: u8 = abi::ty::PORT;
    fn to_bits(self) -> u64 {
        self.0.map_or(0, |p| p.as_ptr().expose_provenance() as u64)
    }
    fn from_bits(bits: u64) -> Self {
        let address = usize::try_from(bits).unwrap_or(0);
        Self(NonNull::new(core::ptr::with_exposed_provenance_mut(address)))
    }
}

impl Port {
    fn queue(&self) -> Option<&abi::PortQueue> {
        // SAFETY: the engine puts only live queues into cells of type port.
        self.0.map(|p| unsafe { p.as_ref() })
    }

    /// Appends all of `bytes`, or nothing if they do not fit or there is no queue. Returns whether
    /// they were appended.
    #[must_use]
    pub fn write(&self, bytes: &[u8]) -> bool {
        self.queue().is_some_and(|q| q.write(bytes))
    }

    /// Fills `out`, or does nothing if there are too few bytes. Returns whether it was filled.
    #[must_use]
    pub fn read(&self, out: &mut [u8]) -> bool {
        self.queue().is_some_and(|q| q.read(out))
    }

    /// Fills `out` and leaves the bytes in the queue. Returns whether it was filled.
    #[must_use]
    pub fn peek(&self, out: &mut [u8]) -> bool {
        self.queue().is_some_and(|q| q.peek(out))
    }

    /// Returns the number of bytes that can be read.
    #[must_use]
    pub fn readable(&self) -> u64 {
        self.queue().map_or(0, abi::PortQueue::readable)
    }

    /// Returns the number of bytes that can be written.
    #[must_use]
    pub fn writable(&self) -> u64 {
        self.queue().map_or(0, abi::PortQueue::writable)
    }

    /// Discards all unread bytes. Only the reader may call this.
    pub fn clear(&self) {
        if let Some(q) = self.queue() {
            q.clear();
        }
    }
}
