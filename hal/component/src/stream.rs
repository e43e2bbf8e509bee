//! Realtime. Rings that a component shares with programs.

use crate::{Touch, Uses, abi};

/// The ring of a component that writes records for a program (`sampler`).
#[derive(Debug)]
pub struct StreamOut(pub(crate) abi::Producer);

impl StreamOut {
    /// Appends a record; `value(i)` gives the bits of each value. False, and counted, when full.
    pub fn put(&mut self, value: impl Fn(usize) -> u64) -> bool {
        self.0.put(value)
    }

    /// How many records wait for the program.
    #[must_use]
    pub fn waiting(&self) -> u32 {
        self.0.waiting()
    }

    /// How many more records fit.
    #[must_use]
    pub fn room(&self) -> u32 {
        self.0.room()
    }
}

/// The ring of a component that reads records from a program (`streamer`).
#[derive(Debug)]
pub struct StreamIn(pub(crate) abi::Consumer);

impl StreamIn {
    /// Takes the oldest record: `value(i, bits)` receives each value. False when there is none.
    pub fn take(&mut self, value: impl FnMut(usize, u64)) -> bool {
        matches!(self.0.take(value), abi::Got::Sample(_))
    }

    /// How many records wait.
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
