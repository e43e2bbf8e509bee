//! Realtime. Lights of the board.

use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Writes},
};
use hal_component::{Error, In, Touch};
use hal_firmware::{Tag, registers};

/// Function half that writes.
#[derive(Touch)]
struct Lights {
    lights: Vec<In<bool>>,
    #[state]
    data: Kept,
}

impl Writes for Lights {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        let lit = |(bit, light): (u32, &In<bool>)| if light.get() { 0x8000_0000 >> bit } else { 0 };
        let data = (0..8).zip(&self.lights).map(lit).fold(0, |all, bit| all | bit);
        self.data.put(to, data);
    }
}

/// Creates the pins of the lights.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    let Some((module, used)) = m.module(Tag::Led) else { return Ok(()) };
    let mut lights = Vec::new();
    for light in 1..=used.min(8) {
        let name = m.at(&format!("led.CR{light:02}"));
        lights.push(m.b.item(&name, "True to light it", false)?);
    }
    let data = Kept::new(m.address(&module, registers::LED_DATA, 0)?);
    m.writes.push(Box::new(Lights { lights, data }));
    Ok(())
}
