//! Kinds of modules: each file drives one.

mod dpll;
mod encoder;
mod inm;
mod ioport;
mod led;
mod outm;
mod pwmgen;
mod raw;
pub(crate) mod sserial;
mod ssr;
mod stepgen;
mod watchdog;

pub(crate) use sserial::{Element, Flow, Form, UsedRemote};
pub(crate) use watchdog::RESET;

use crate::making::Making;
use hal_component::{Error, In};
use hal_firmware::{Module, Tag};

/// Creates the pins of one kind of module.
type Make = fn(&mut Making<'_, '_>) -> Result<(), Error>;

/// All kinds, in the order in which their registers are read and written, each with the modules whose instances are counted and
/// whose I/O pins are taken. The ports of smart serial are counted where they are asked for their remotes.
const ALL: &[(&[Tag], Make)] = &[
    (&[Tag::Dpll], dpll::make),
    (&[Tag::Encoder, Tag::MuxedEncoder, Tag::MuxedEncoderSelect], encoder::make),
    (&[Tag::StepGenerator], stepgen::make),
    (&[Tag::Pwm], pwmgen::make),
    (&[Tag::Inputs, Tag::InputMux], inm::make),
    (&[Tag::Outputs], outm::make),
    (&[Tag::Ssr], ssr::make),
    (&[Tag::Led], led::make),
    // Before the I/O pins, which the used channels take.
    (&[], sserial::make),
    (&[Tag::IoPort], ioport::make),
    // Last of the writes: the packet that restarts the watchdog has the cycle's other writes, too. If a cycle needs several packets,
    // it is the last of them.
    (&[Tag::Watchdog], watchdog::make),
    // Last: its place in the question changes.
    (&[], raw::make),
];

/// Returns the number of instances of a module that can be used. Modules that nothing here drives have none, and their I/O pins
/// are free.
pub(crate) fn instances(module: &Module) -> Option<(Tag, u8)> {
    let tag = module.kind().filter(|tag| ALL.iter().any(|(tags, _)| tags.contains(tag)))?;
    let instances = match tag {
        // One instance of lights has those of the board.
        Tag::Led => LIGHTS,
        // The register of enables has a bit for each.
        Tag::Pwm => module.instances.min(32),
        _ => module.instances,
    };
    Some((tag, instances))
}

/// Lights of a board that has any.
const LIGHTS: u8 = 4;

/// Creates the pins of all modules.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    ALL.iter().try_for_each(|(_, make)| make(m))
}

/// Meaning of the pins that select a timer.
const TIMER: &str = "Timer of the card's clock at which the counts are latched: 1 to 4, 0 for the read itself, -1 for none";

/// Returns the register of such a pin; a number of no timer selects none.
fn timer(timer: In<i32>) -> u32 {
    let number = timer.get();
    match u32::try_from(number) {
        Ok(number @ 0..=4) => number << 12 | 1 << 15,
        _ => 0,
    }
}
