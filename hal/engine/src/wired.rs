//! Texts of components: a pin that one names as `{NAME}` is shown with its wiring.

use crate::{Engine, graph::Item, name::Name};
use hal_protocol::Direction;

impl Engine {
    /// Replaces each `{NAME}` by that name and how the pin is wired.
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
            match name {
                "" => shown.push_str("{}"),
                name => shown.push_str(&self.pin_with_wiring(name)),
            }
            rest = after;
        }
        shown.push_str(rest);
        shown
    }

    /// A pin's name, its signal, and the pins that write that.
    fn pin_with_wiring(&self, name: &str) -> String {
        let graph = &self.graph;
        let Some(pin) = graph.pins.get(name) else { return name.to_owned() };
        let signal = graph.signal_of(*pin);
        let Some((ix, signal)) = signal.and_then(|ix| Some((ix, graph.signal(ix)?))) else {
            return format!("{name} (not linked)");
        };
        let pins = graph.pins_of(ix);
        let writers = pins.iter().filter_map(|ix| graph.item(*ix));
        let writers = writers.filter(|item| item.direction != Direction::In).map(Item::shown);
        let mut writers: Vec<&str> = writers.map(Name::as_str).filter(|n| *n != name).collect();
        writers.sort_unstable();
        let signal = signal.name.as_str();
        if writers.is_empty() {
            return format!("{name} (signal '{signal}', which no pin writes)");
        }
        format!("{name} (signal '{signal}', written by {})", writers.join(", "))
    }
}
