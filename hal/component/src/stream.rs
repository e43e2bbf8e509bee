//! Realtime. Rings that a component shares with programs.

use crate::{Touch, Uses, abi};

/// Ring that a component writes and a program reads (`sampler`).
#[derive(Debug)]
pub struct StreamOut(pub(crate) abi::Producer);

impl StreamOut {
    /// Appends a record; `value(i)` returns the bits of each value. Returns false if the ring is
    /// full; the record is then counted as lost.
    pub fn put(&mut self, value: impl Fn(usize) -> u64) -> bool {
        self.0.put(value)
    }

    /// Returns the number of records that wait for the program.
    #[must_use]
    pub fn waiting(&self) -> u32 {
        self.0.waiting()
    }

    /// Returns the number of further records that fit.
    #[must_use]
    pub fn room(&self) -> u32 {
        self.0.room()
    }
}

/// Ring that a program writes and a component reads (`streamer`).
#[derive(Debug)]
pub struct StreamIn(pub(crate) abi::Consumer);

impl StreamIn {
    /// Takes the oldest record and calls `value(i, bits)` for each value. Returns false if there is
    /// none.
    pub fn take(&mut self, value: impl FnMut(usize, u64)) -> bool {
        matches!(self.0.take(value), abi::Got::Sample(_))
    }

    /// Returns the number of waiting records.
    #[must_use]
    pub fn waiting(&self) -> u32 {
        self.0.waiting()
    }
}

impl Touch for StreamOut {
    fn touch(&self, _: &mut Uses) {}
}
impl Touch for StreamIn {
    fn touch(&self, _: &mut Uses) {}
}
