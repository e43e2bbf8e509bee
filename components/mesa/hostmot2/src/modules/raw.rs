//! Realtime. Any register, for people who debug a firmware.

use crate::{
    link::Outgoing,
    making::Making,
    module::{Cycle, Writes},
};
use hal_component::{Error, In, InSet, Io, Out, Touch, pins};

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
        if let Ok(address @ 0..=0xFFFC) = u16::try_from(self.pins.write_address.get()) {
            if address.is_multiple_of(4) {
                to.put(address, self.pins.write_data.get());
            }
        }
    }
}

/// Creates the pins, if `config=` asks for them.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    if m.config.raw {
        let pins = Raw::make(m.b, m.name)?;
        m.writes.push(Box::new(Poke { pins }));
    }
    Ok(())
}
