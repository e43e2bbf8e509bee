//! Stand-ins on the real clock, which nothing may depend on that moves or stops.

use super::wires::Wires;
use hal_protocol::Direction;
use std::collections::BTreeSet;

/// Returns the first of these outputs that reaches what motion depends on, with that pin.
pub(super) fn depended<'a>(
    wires: &Wires,
    outputs: impl Iterator<Item = &'a str>,
) -> Option<(&'a str, String)> {
    outputs.into_iter().find_map(|output| reached(wires, output).map(|pin| (output, pin)))
}

/// Returns a pin of safety or feedback that an output reaches, through any components.
fn reached(wires: &Wires, output: &str) -> Option<String> {
    let mut todo = vec![output.to_owned()];
    let mut seen: BTreeSet<String> = todo.iter().cloned().collect();
    while let Some(writer) = todo.pop() {
        let Some(signal) = wires.signal_of(&writer).and_then(|s| wires.signals.get(s)) else {
            continue;
        };
        for (dir, reader) in &signal.pins {
            if *dir == Direction::Out || *reader == writer {
                continue;
            }
            if is_depended(reader) {
                return Some(reader.clone());
            }
            // What motion and the task make of an input is theirs.
            let owner = wires.pins.get(reader).map(|pin| pin.owner.as_str());
            if matches!(owner, Some("motmod" | "iocontrol" | "halui" | "task")) {
                continue;
            }
            let base = reader.rsplit_once('.').map_or(reader.as_str(), |(base, _)| base);
            let outputs = wires.pins.iter().filter(|(name, pin)| {
                pin.direction == Direction::Out
                    && name.rsplit_once('.').is_some_and(|(other, _)| other == base)
            });
            for (name, _) in outputs {
                if seen.insert(name.clone()) {
                    todo.push(name.clone());
                }
            }
        }
    }
    None
}

/// Returns whether motion, a stop or an enabled output depends on this input.
fn is_depended(pin: &str) -> bool {
    let parts: Vec<&str> = pin.split('.').collect();
    match parts[..] {
        ["joint", _, end] => {
            end.ends_with("-sw-in")
                || matches!(end, "amp-fault-in" | "motor-pos-fb" | "index-enable")
        }
        ["iocontrol", _, end] => end == "emc-enable-in",
        ["motion", end] => end == "enable",
        ["spindle", _, end] => end == "amp-fault-in",
        [.., end] => {
            let end = end.to_ascii_lowercase();
            matches!(&*end, "enable" | "feedback" | "ok-in" | "fault-in" | "amp-enable")
        }
        [] => false,
    }
}
