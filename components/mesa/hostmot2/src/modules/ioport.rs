//! Realtime. I/O pins: free ones, and the levels of those that modules use.

use super::sserial;
use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Reads, Writes},
    plan::{Place, ReadAnswer},
};
use hal_component::{Error, In, Out, ParamRw, Touch, pins};
use hal_firmware::{Pin, Tag, registers};

pins! {
    /// Level of an I/O pin.
    struct Level {
        /// Level of the I/O pin.
        level: Out<bool> = "in", false;
        /// Opposite of the level of the I/O pin.
        not: Out<bool> = "in_not", false;
    }
}

pins! {
    /// Form of an output.
    struct Form {
        /// True if the output is inverted.
        is_inverted: ParamRw<bool> = "invert_output", false;
        /// True if the output only pulls down, and is open otherwise.
        is_open_drain: ParamRw<bool> = "is_opendrain", false;
    }
}

pins! {
    /// A free I/O pin as an output.
    struct Free {
        /// Level of the I/O pin while it is an output.
        out: In<bool> = "out", false;
        /// True to make the I/O pin an output.
        is_output: ParamRw<bool> = "is_output", false;
    }
}

/// Levels of one port.
#[derive(Touch)]
struct PortLevels {
    #[state]
    data: Place,
    pins: Vec<(Bit, Level)>,
}

/// Mask of one pin within its port.
#[derive(Clone, Copy)]
struct Bit(u32);

impl Touch for Bit {
    fn touch(&self, _: &mut hal_component::Uses) {}
}

/// Function half that reads.
#[derive(Touch)]
struct Levels {
    ports: Vec<PortLevels>,
}

impl Reads for Levels {
    fn read(&mut self, answer: ReadAnswer<'_>, _: Cycle, _: bool) {
        for port in &self.ports {
            let data = answer.get(port.data);
            for (bit, pin) in &port.pins {
                let level = data & bit.0 != 0;
                pin.level.set(level);
                pin.not.set(!level);
            }
        }
    }
}

/// Outputs of one port.
#[derive(Touch)]
struct PortOutputs {
    free: Vec<(Bit, Free)>,
    forms: Vec<(Bit, Form)>,
    /// Pins that modules drive.
    #[state]
    driven: u32,
    /// Pins that modules use.
    #[state]
    taken: u32,
    #[state]
    data: u16,
    #[state]
    direction: Kept,
    #[state]
    source: Kept,
    #[state]
    open_drain: Kept,
    #[state]
    invert: Kept,
}

impl PortOutputs {
    fn write(&mut self, to: &mut Outgoing<'_>) {
        let (mut data, mut direction) = (0, self.driven);
        for (bit, pin) in &self.free {
            data |= if pin.out.get() { bit.0 } else { 0 };
            direction |= if pin.is_output.get() { bit.0 } else { 0 };
        }
        let (mut open_drain, mut invert) = (0, 0);
        for (bit, pin) in &self.forms {
            let drains = pin.is_open_drain.get();
            // An open drain is an output whose driver only pulls down.
            open_drain |= if drains { bit.0 } else { 0 };
            invert |= if pin.is_inverted.get() { bit.0 } else { 0 };
        }
        direction |= open_drain;
        to.put(self.data, data);
        self.invert.put(to, invert);
        self.open_drain.put(to, open_drain);
        self.source.put(to, self.taken);
        self.direction.put(to, direction);
    }
}

/// Function half that writes.
#[derive(Touch)]
struct Outputs {
    ports: Vec<PortOutputs>,
}

impl Writes for Outputs {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        for port in &mut self.ports {
            port.write(to);
        }
    }
}

/// Creates the pins of all I/O pins.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    let Some((module, ports)) = m.module(Tag::IoPort) else { return Ok(()) };
    let width = m.card.identification.port_width as usize;
    let (mut levels, mut outputs) = (Vec::new(), Vec::new());
    let pins = m.card.pins.clone();
    for (port, pins) in (0..ports).zip(pins.chunks(width)) {
        let data = m.read(&module, registers::PORT_DATA, port)?;
        let kept = |register| m.address(&module, register, port).map(Kept::new);
        let mut output = PortOutputs {
            free: Vec::new(),
            forms: Vec::new(),
            driven: 0,
            taken: 0,
            direction: kept(registers::PORT_DIRECTION)?,
            source: kept(registers::PORT_SOURCE)?,
            open_drain: kept(registers::PORT_OPEN_DRAIN)?,
            invert: kept(registers::PORT_INVERT)?,
            data: m.address(&module, registers::PORT_DATA, port)?,
        };
        let mut level = PortLevels { data, pins: Vec::new() };
        for (at, pin) in pins.iter().enumerate() {
            let bit = Bit(1 << at);
            let name = m.at(&format!("gpio.{:03}", usize::from(port) * width + at));
            let taken = is_used(m, *pin);
            m.taken.push(taken);
            level.pins.push((bit, Level::make(m.b, &name)?));
            if !taken {
                output.free.push((bit, Free::make(m.b, &name)?));
            }
            if !taken || pin.is_output {
                let name = form_name(m, *pin, taken).unwrap_or(name);
                output.forms.push((bit, Form::make(m.b, &name)?));
            }
            output.taken |= if taken { bit.0 } else { 0 };
            output.driven |= if taken && pin.is_output { bit.0 } else { 0 };
        }
        levels.push(level);
        outputs.push(output);
    }
    m.reads.push(Box::new(Levels { ports: levels }));
    m.writes.push(Box::new(Outputs { ports: outputs }));
    Ok(())
}

/// Returns the name under which the form of a module's output is set: that of the module's pin, where it has one.
fn form_name(m: &Making<'_, '_>, pin: Pin, taken: bool) -> Option<String> {
    let tag = pin.kind().filter(|_| taken)?;
    if tag == Tag::SmartSerial {
        let (channel, sort) = sserial::channel(pin.number)?;
        return Some(m.at(&format!("sserial.{:02}.{sort}{channel}", pin.instance)));
    }
    let output = match (tag, pin.number) {
        (Tag::StepGenerator, 1) => "step",
        (Tag::StepGenerator, 2) => "direction",
        (Tag::Pwm, 1) => "out0",
        (Tag::Pwm, 2) => "out1",
        (Tag::Pwm, 3) => "enable",
        (Tag::MuxedEncoderSelect, 1) => "sel0",
        _ => return None,
    };
    let kind = if tag == Tag::MuxedEncoderSelect { "encoder" } else { tag.name() };
    Some(m.at(&format!("{kind}.{:02}.{output}", pin.instance)))
}

/// Returns whether a used instance of a module has a pin.
fn is_used(m: &Making<'_, '_>, pin: Pin) -> bool {
    let Some(tag) = pin.kind() else { return false };
    if tag == Tag::MuxedEncoderSelect {
        return m.module(Tag::MuxedEncoder).is_some();
    }
    if tag == Tag::SmartSerial {
        let channels = m.channels.get(usize::from(pin.instance)).copied().unwrap_or(0);
        return sserial::channel(pin.number)
            .is_some_and(|(channel, _)| channel < 8 && channels >> channel & 1 == 1);
    }
    let Some((_, used)) = m.module(tag) else { return false };
    if tag == Tag::StepGenerator && pin.number > m.config.step_width.unwrap_or(2) {
        return false;
    }
    pin.is_shared() || pin.instance < used
}
