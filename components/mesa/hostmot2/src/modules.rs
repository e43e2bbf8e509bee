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
use hal_firmware::Tag;

/// Creates the pins of one kind of module.
type Make = fn(&mut Making<'_, '_>) -> Result<(), Error>;

/// All kinds, in the order in which their registers are read and written.
const ALL: &[Make] = &[
    dpll::make,
    encoder::make,
    stepgen::make,
    pwmgen::make,
    inm::make,
    outm::make,
    ssr::make,
    led::make,
    // Before the I/O pins, which the used channels take.
    sserial::make,
    ioport::make,
    // Behind the rest: a packet that lets its time begin again has all of it, or the last part where a cycle needs several packets.
    watchdog::make,
    // Last: its place in the question changes.
    raw::make,
];

/// Kinds whose instances the entries of `config` limit. The ports of smart serial are counted where they are asked for their
/// remotes; the I/O pins of all other kinds, which nothing here drives, are free.
pub(crate) const COUNTED: &[Tag] = &[
    Tag::Watchdog,
    Tag::IoPort,
    Tag::Encoder,
    Tag::MuxedEncoder,
    Tag::MuxedEncoderSelect,
    Tag::StepGenerator,
    Tag::Pwm,
    Tag::Dpll,
    Tag::Inputs,
    Tag::InputMux,
    Tag::Outputs,
    Tag::Led,
    Tag::Ssr,
];

/// Creates the pins of all modules.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    ALL.iter().try_for_each(|make| make(m))
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
