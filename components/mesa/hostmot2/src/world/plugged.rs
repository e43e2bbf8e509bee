//! Pins of the terminals of remotes, from the remotes' accounts.

use super::remotes::{RemoteTerminals, RemoteWorld, TerminalPins};
use crate::{
    making::Making,
    modules::{Element, Flow, Form},
};
use hal_component::Error;

/// Creates the pins around all remotes.
pub(super) fn make(m: &mut Making<'_, '_>) -> Result<Vec<RemoteWorld>, Error> {
    let mut worlds = Vec::new();
    for remote in m.remotes.clone() {
        let name = m.at(&format!("sim.{}.{}.{}", remote.kind, remote.port, remote.channel));
        let about = "True while the remote's cable is plugged in";
        let plugged = m.b.simulated(&format!("{name}.plugged"), about, true)?;
        let mut terminals = Vec::new();
        for element in &remote.elements {
            if element.form == Form::Padding {
                continue;
            }
            terminals.push(RemoteTerminals {
                name: element.label.as_str().into(),
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

fn pins(m: &mut Making<'_, '_>, name: &str, element: &Element) -> Result<TerminalPins, Error> {
    let enters = element.flow == Flow::In;
    // Numbers of a remote without a range have no unit.
    let has_range = element.max > 0.0 && element.form == Form::Unsigned;
    Ok(match (element.form, enters) {
        (Form::Bits, true) => {
            let about = "Level that is connected to the input";
            let pins =
                (0..element.bits).map(|n| m.b.simulated(&format!("{name}-{n:02}"), about, false));
            TerminalPins::Levels(pins.collect::<Result<_, _>>()?)
        }
        (Form::Bits, false) => {
            let about = "Level that a meter reads at the output";
            let pins =
                (0..element.bits).map(|n| m.b.simulated(&format!("{name}-{n:02}"), about, false));
            TerminalPins::ShownLevels(pins.collect::<Result<_, _>>()?)
        }
        (_, true) if has_range => {
            TerminalPins::Value(m.b.simulated(name, "Value at the input", 0.0)?)
        }
        (_, false) if has_range => {
            TerminalPins::ShownValue(m.b.simulated(name, "Value at the output", 0.0)?)
        }
        (_, true) => TerminalPins::Raw(m.b.simulated(name, "Number that the remote has", 0)?),
        (_, false) => {
            TerminalPins::ShownRaw(m.b.simulated(name, "Number that the remote has got", 0)?)
        }
    })
}
