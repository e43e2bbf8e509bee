//! Messages of components: a pin that a message names as `{NAME}` is shown with its wiring.

use crate::{
    graph::{Graph, Item},
    name::Name,
};
use hal_protocol::Direction;

impl Graph {
    /// Replaces each `{NAME}` of a pin by that name and the pin's wiring.
    pub(crate) fn with_wiring(&self, text: &str) -> String {
        let mut shown = String::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            shown.push_str(before);
            let Some((name, after)) = after.split_once('}') else {
                shown.push('{');
                rest = after;
                continue;
            };
            match self.pin_with_wiring(name) {
                Some(pin) => shown.push_str(&pin),
                None => shown.extend(["{", name, "}"]),
            }
            rest = after;
        }
        shown.push_str(rest);
        shown
    }

    /// Describes a pin: its name, its signal, and the pins at the other end of the signal. These
    /// are the pins that write the signal or, for an output, the pins that read it.
    fn pin_with_wiring(&self, name: &str) -> Option<String> {
        let graph = self;
        let pin = graph.pin_named(name)?;
        let item = graph.item(pin)?;
        let signal = graph.signal_of(pin);
        let Some((ix, signal)) = signal.and_then(|ix| Some((ix, graph.signal(ix)?))) else {
            return Some(format!("{name} (not linked)"));
        };
        let signal = signal.name.as_str();
        let (end, verb, done) = match item.direction {
            Direction::Out => (Direction::Out, "reads", "read"),
            _ => (Direction::In, "writes", "written"),
        };
        let pins = graph.pins_of(ix);
        let others = pins.iter().filter(|other| **other != pin).filter_map(|ix| graph.item(*ix));
        let others = others.filter(|other| other.direction != end).map(Item::shown);
        let mut others: Vec<&str> = others.map(Name::as_str).collect();
        others.sort_unstable();
        Some(if others.is_empty() {
            format!("{name} (signal '{signal}', which no other pin {verb})")
        } else {
            format!("{name} (signal '{signal}', {done} by {})", others.join(", "))
        })
    }
}
