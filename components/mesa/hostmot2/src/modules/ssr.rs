//! Realtime. Solid-state relays.

use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Writes},
    numbers::whole,
};
use hal_component::{Error, In, Touch};
use hal_firmware::{Tag, registers};

/// Bit of the rate register that lets the chopper run.
const ENABLED: u32 = 1 << 12;

/// Relays of one instance.
#[derive(Touch)]
struct Relays {
    relays: Vec<(Relay, In<bool>)>,
    rate: In<u32>,
    #[state]
    clock: f64,
    #[state]
    data: Kept,
    #[state]
    rate_register: Kept,
}

/// Command of one relay, and its place in the register.
struct Relay {
    on: In<bool>,
    bit: u32,
}

impl Touch for Relay {
    fn touch(&self, uses: &mut hal_component::Uses) {
        self.on.touch(uses);
    }
}

impl Relays {
    fn write(&mut self, to: &mut Outgoing<'_>) {
        // Half a period of the chopper, in periods of the clock less two.
        let half = libm::floor(self.clock / (2.0 * f64::from(self.rate.get().max(1)))) - 2.0;
        self.rate_register.put(to, whole(half, 4095) | ENABLED);
        let on = |(relay, invert): &(Relay, In<bool>)| {
            if relay.on.get() == invert.get() { 0 } else { relay.bit }
        };
        let data = self.relays.iter().map(on).fold(0, |all, bit| all | bit);
        self.data.put(to, data);
    }
}

/// Function half that writes.
#[derive(Touch)]
struct All {
    instances: Vec<Relays>,
}

impl Writes for All {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        for instance in &mut self.instances {
            instance.write(to);
        }
    }
}

/// Creates the pins of all relays.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    let Some((module, used)) = m.module(Tag::Ssr) else { return Ok(()) };
    let mut instances = Vec::new();
    for instance in 0..used {
        let mut relays = Vec::new();
        for number in m.outputs(Tag::Ssr, instance, 31) {
            let name = m.at(&format!("ssr.{instance:02}.out-{number:02}"));
            let on = m.b.item(&name, "True to switch the relay on", false)?;
            let name = m.at(&format!("ssr.{instance:02}.invert-{number:02}"));
            let invert =
                m.b.item(&name, "True to switch the relay on while `out` is FALSE", false)?;
            relays.push((Relay { on, bit: 1 << number }, invert));
        }
        let name = m.at(&format!("ssr.{instance:02}.rate"));
        let about = "Rate of the chopper, in hertz; values out of range saturate";
        instances.push(Relays {
            relays,
            rate: m.b.item(&name, about, 1_000_000)?,
            clock: m.clock(&module)?,
            data: Kept::new(m.address(&module, registers::SSR_DATA, instance)?),
            rate_register: Kept::new(m.address(&module, registers::SSR_RATE, instance)?),
        });
    }
    m.writes.push(Box::new(All { instances }));
    Ok(())
}
