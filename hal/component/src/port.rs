//! Realtime. The value of a pin of type `port`.

use crate::{Value, abi};
use core::ptr::NonNull;

/// The byte queue that a pin of type `port` is linked to, if there is one.
///
/// One pin of a signal writes and one reads; the queue lives as long as its signal.
#[derive(Clone, Copy, Debug, Default)]
pub struct Port(Option<NonNull<abi::PortQueue>>);

// SAFETY: a `PortQueue` is shared through atomics.
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

    /// Appends all of `bytes`, or nothing when they do not fit or no queue is there.
    #[must_use]
    pub fn write(&self, bytes: &[u8]) -> bool {
        self.queue().is_some_and(|q| q.write(bytes))
    }

    /// Fills `out`, or does nothing when there are too few bytes.
    #[must_use]
    pub fn read(&self, out: &mut [u8]) -> bool {
        self.queue().is_some_and(|q| q.read(out))
    }

    /// Fills `out` and leaves the bytes in the queue.
    #[must_use]
    pub fn peek(&self, out: &mut [u8]) -> bool {
        self.queue().is_some_and(|q| q.peek(out))
    }

    /// How many bytes wait to be read.
    #[must_use]
    pub fn readable(&self) -> u64 {
        self.queue().map_or(0, abi::PortQueue::readable)
    }

    /// How many bytes fit.
    #[must_use]
    pub fn writable(&self) -> u64 {
        self.queue().map_or(0, abi::PortQueue::writable)
    }

    /// Throws away what waits; the reader's call.
    pub fn clear(&self) {
        if let Some(q) = self.queue() {
            q.clear();
        }
    }
}
