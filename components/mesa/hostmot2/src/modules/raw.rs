//! Realtime. Any register, for people who debug a firmware.

use crate::{
    link::Outgoing,
    making::Making,
    module::{Cycle, Writes},
};
use hal_component::{Error, In, InSet, Touch, pins};

pins! {
    /// The pins.
    struct Raw {
        /// Address of a register, a multiple of 4 from 0 to 0xFFFC.
        address: In<u32> = "raw.write_address", 0;
        /// Value to write.
        data: In<u32> = "raw.write_data", 0;
        /// TRUE to write it once; the driver sets it FALSE then.
        strobe: InSet<bool> = "raw.write_strobe", false;
    }
}

/// Function half that writes.
#[derive(Touch)]
struct Poke {
    pins: Raw,
}

impl Writes for Poke {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        if !self.pins.strobe.get() {
            return;
        }
        self.pins.strobe.set(false);
        if let Ok(address @ 0..=0xFFFC) = u16::try_from(self.pins.address.get()) {
            if address.is_multiple_of(4) {
                to.put(address, self.pins.data.get());
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
