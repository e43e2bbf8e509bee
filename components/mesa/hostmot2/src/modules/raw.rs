//! Realtime. Any register, for people who debug a firmware.

use crate::{
    link::Outgoing,
    making::Making,
    module::{Cycle, Reads, Writes},
    plan::{Place, ReadAnswer},
};
use core::sync::atomic::{AtomicU16, Ordering::Relaxed};
use hal_component::{Error, In, InSet, Io, Out, Touch, pins};
use std::sync::Arc;

pins! {
    /// The pins.
    struct Raw {
        /// Address of a register to read, a multiple of 4 from 0 to 0xFFFC.
        read_address: In<u32> = "raw.read_address", 0;
        /// Value of that register.
        read_data: Out<u32> = "raw.read_data", 0;
        /// Address of a register to write, a multiple of 4 from 0 to 0xFFFC.
        write_address: In<u32> = "raw.write_address", 0;
        /// Value to write.
        write_data: In<u32> = "raw.write_data", 0;
        /// TRUE to write it once; the driver sets it FALSE then.
        write_strobe: InSet<bool> = "raw.write_strobe", false;
        /// Without effect; the driver sets it FALSE.
        dump_state: Io<bool> = "raw.dump_state", false;
    }
}

/// Function half that reads.
#[derive(Touch)]
struct Peek {
    pins: Raw,
    #[state]
    value: Place,
    #[state]
    address: Arc<AtomicU16>,
}

impl Reads for Peek {
    fn read(&mut self, answer: ReadAnswer<'_>, _: Cycle, _: bool) {
        self.pins.read_data.set(answer.get(self.value));
        self.pins.dump_state.set(false);
        // The next question asks for it.
        if let Some(address) = register(self.pins.read_address) {
            self.address.store(address, Relaxed);
        }
    }
}

/// Function half that writes.
#[derive(Touch)]
struct Poke {
    pins: Raw,
}

impl Writes for Poke {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        if !self.pins.write_strobe.get() {
            return;
        }
        self.pins.write_strobe.set(false);
        if let Some(address) = register(self.pins.write_address) {
            to.put(address, self.pins.write_data.get());
        }
    }
}

/// Returns the address of a register, if the pin has one.
fn register(pin: In<u32>) -> Option<u16> {
    u16::try_from(pin.get()).ok().filter(|at| at.is_multiple_of(4))
}

/// Creates the pins, if `config=` asks for them.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    if m.config.raw {
        let pins = Raw::make(m.b, m.name)?;
        let (value, address) = (m.plan.read_variable(), Arc::clone(&m.raw_address));
        m.reads.push(Box::new(Peek { pins: pins.clone(), value, address }));
        m.writes.push(Box::new(Poke { pins }));
    }
    Ok(())
}
