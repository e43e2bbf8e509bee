//! Realtime. Outputs without a chopper.

use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Writes},
};
use hal_component::{Error, In, Touch, Uses};
use hal_firmware::{Tag, registers};

/// Output with its place in the register.
struct Output {
    on: In<bool>,
    invert: In<bool>,
    bit: u32,
}

impl Touch for Output {
    fn touch(&self, uses: &mut Uses) {
        self.on.touch(uses);
        self.invert.touch(uses);
    }
}

/// Function half that writes.
#[derive(Touch)]
struct Outputs {
    instances: Vec<(Vec<Output>, Register)>,
}

/// Register of one instance.
struct Register(Kept);

impl Touch for Register {
    fn touch(&self, _: &mut Uses) {}
}

impl Writes for Outputs {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        for (outputs, data) in &mut self.instances {
            let on = |output: &Output| {
                if output.on.get() == output.invert.get() { 0 } else { output.bit }
            };
            data.0.put(to, outputs.iter().map(on).fold(0, |all, bit| all | bit));
        }
    }
}

/// Creates the pins of all outputs.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    let Some((module, used)) = m.module(Tag::Outputs) else { return Ok(()) };
    let mut instances = Vec::new();
    for instance in 0..used {
        let mut outputs = Vec::new();
        for number in m.outputs(Tag::Outputs, instance, 32) {
            let at = |what: &str| format!("outm.{instance:02}.{what}-{number:02}");
            let (on, invert) = (m.at(&at("out")), m.at(&at("invert")));
            outputs.push(Output {
                on: m.b.item(&on, "True to switch the output on", false)?,
                invert: m.b.item(&invert, "True to switch it on while `out` is false", false)?,
                bit: 1 << number,
            });
        }
        let data = Kept::new(m.address(&module, registers::OUTPUTS_DATA, instance)?);
        instances.push((outputs, Register(data)));
    }
    m.writes.push(Box::new(Outputs { instances }));
    Ok(())
}
