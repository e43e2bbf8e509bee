//! Realtime. Parts of the driver: each drives the instances of one kind of module.

use crate::{link::Outgoing, plan::ReadAnswer};
use hal_component::{Touch, Uses};

/// Moment of a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cycle {
    /// Period of the thread in seconds.
    pub(crate) period: f64,
}

/// Half of a module that the function `read` runs.
pub(crate) trait Reads: Touch + Send + 'static {
    /// Takes the values of an answer. `fresh` is false if the card may have missed what was written before it: then
    /// nothing that was armed counts as done.
    fn read(&mut self, answer: ReadAnswer<'_>, cycle: Cycle, fresh: bool);
}

/// Half of a module that the function `write` runs.
pub(crate) trait Writes: Touch + Send + 'static {
    /// Writes the registers of this cycle.
    fn write(&mut self, to: &mut Outgoing<'_>, cycle: Cycle);
}

impl Touch for Box<dyn Reads> {
    fn touch(&self, uses: &mut Uses) {
        (**self).touch(uses);
    }
}

impl Touch for Box<dyn Writes> {
    fn touch(&self, uses: &mut Uses) {
        (**self).touch(uses);
    }
}
