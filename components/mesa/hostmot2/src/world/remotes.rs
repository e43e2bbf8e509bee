//! Realtime. Terminals of smart-serial remotes as pins.

use super::hidden;
use crate::{
    making::Making,
    modules::{Element, Flow, Form},
};
use hal_card::{Card, Remote};
use hal_component::{Error, In, Out, Touch, Uses};

/// Terminals of one remote, and its cable.
#[derive(Clone)]
pub(super) struct RemoteWorld {
    port: usize,
    channel: usize,
    plugged: In<bool>,
    terminals: Vec<RemoteTerminals>,
}

/// Terminals of one datum.
#[derive(Clone)]
struct RemoteTerminals {
    /// Name of the datum, as the remote has it.
    name: String,
    bits: u8,
    max: f64,
    pins: Pins,
}

#[derive(Clone)]
enum Pins {
    Levels(Vec<In<bool>>),
    Value(In<f64>),
    Raw(In<u32>),
    ShownLevels(Vec<Out<bool>>),
    ShownValue(Out<f64>),
    ShownRaw(Out<u32>),
}

impl Touch for RemoteWorld {
    fn touch(&self, uses: &mut Uses) {
        self.plugged.touch(uses);
        for terminal in &self.terminals {
            match &terminal.pins {
                Pins::Levels(pins) => pins.touch(uses),
                Pins::Value(pin) => pin.touch(uses),
                Pins::Raw(pin) => pin.touch(uses),
                Pins::ShownLevels(pins) => pins.touch(uses),
                Pins::ShownValue(pin) => pin.touch(uses),
                Pins::ShownRaw(pin) => pin.touch(uses),
            }
        }
    }
}

impl RemoteWorld {
    pub(super) fn put_in(&self, card: &mut Card) {
        card.cut(self.port, self.channel, !self.plugged.get());
        let Some(remote) = card.remote_mut(self.port, self.channel) else { return };
        for terminal in &self.terminals {
            terminal.put_in(remote);
        }
    }

    pub(super) fn put_out(&self, card: &Card) {
        let Some(remote) = card.remote(self.port, self.channel) else { return };
        for terminal in &self.terminals {
            terminal.put_out(remote);
        }
    }
}

impl RemoteTerminals {
    fn put_in(&self, remote: &mut Remote) {
        let value = match &self.pins {
            Pins::Levels(levels) => levels
                .iter()
                .take(64)
                .enumerate()
                .fold(0, |all, (n, level)| all | u64::from(level.get()) << n),
            Pins::Value(value) => raw(value.get() / self.max * full(self.bits)),
            Pins::Raw(value) => u64::from(value.get()),
            Pins::ShownLevels(_) | Pins::ShownValue(_) | Pins::ShownRaw(_) => return,
        };
        remote.set(&self.name, value);
    }

    fn put_out(&self, remote: &Remote) {
        let Some(value) = remote.value(&self.name) else { return };
        match &self.pins {
            Pins::ShownLevels(levels) => {
                for (n, level) in levels.iter().take(64).enumerate() {
                    level.set(value >> n & 1 == 1);
                }
            }
            Pins::ShownValue(pin) => pin.set(value as f64 / full(self.bits) * self.max),
            Pins::ShownRaw(pin) => pin.set(u32::try_from(value).unwrap_or(u32::MAX)),
            Pins::Levels(_) | Pins::Value(_) | Pins::Raw(_) => {}
        }
    }
}

/// Returns the largest number of so many bits.
fn full(bits: u8) -> f64 {
    libm::exp2(f64::from(bits)) - 1.0
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
fn raw(x: f64) -> u64 {
    libm::floor(x + 0.5) as u64
}

/// Creates the pins around all remotes.
pub(super) fn make(m: &mut Making<'_, '_>) -> Result<Vec<RemoteWorld>, Error> {
    let mut worlds = Vec::new();
    for remote in m.remotes.clone() {
        let name = m.at(&format!("sim.{}.{}.{}", remote.kind, remote.port, remote.channel));
        let about = "True while the remote's cable is plugged in";
        let plugged = hidden(m, &format!("{name}.plugged"), about, true)?;
        let mut terminals = Vec::new();
        for element in &remote.elements {
            if element.form == Form::Padding {
                continue;
            }
            terminals.push(RemoteTerminals {
                name: element.label.clone(),
                bits: element.bits,
                max: f64::from(element.max),
                pins: pins(m, &format!("{name}.{}", element.name), element)?,
            });
        }
        let (port, channel) = (usize::from(remote.port), usize::from(remote.channel));
        worlds.push(RemoteWorld { port, channel, plugged, terminals });
    }
    Ok(worlds)
}

fn pins(m: &mut Making<'_, '_>, name: &str, element: &Element) -> Result<Pins, Error> {
    let enters = element.flow == Flow::In;
    // Numbers of a remote without a range have no unit.
    let has_range = element.max > 0.0 && element.form == Form::Unsigned;
    Ok(match (element.form, enters) {
        (Form::Bits, true) => {
            let about = "Level that is connected to the input";
            let pins =
                (0..element.bits).map(|n| hidden(m, &format!("{name}-{n:02}"), about, false));
            Pins::Levels(pins.collect::<Result<_, _>>()?)
        }
        (Form::Bits, false) => {
            let about = "Level that a meter reads at the output";
            let pins =
                (0..element.bits).map(|n| hidden(m, &format!("{name}-{n:02}"), about, false));
            Pins::ShownLevels(pins.collect::<Result<_, _>>()?)
        }
        (_, true) if has_range => Pins::Value(hidden(m, name, "Value at the input", 0.0)?),
        (_, false) if has_range => Pins::ShownValue(hidden(m, name, "Value at the output", 0.0)?),
        (_, true) => Pins::Raw(hidden(m, name, "Number that the remote has", 0)?),
        (_, false) => Pins::ShownRaw(hidden(m, name, "Number that the remote has got", 0)?),
    })
}
