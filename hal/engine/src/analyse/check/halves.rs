//! Checks of pins that belong together, of which only one is linked.

use super::{Look, finding};
use crate::graph::{Item, Ix};
use hal_protocol::{Code, Direction};

/// Pairs of pins of a channel. While the first is linked, the second must be connected too.
const PAIRS: &[(&str, &str)] = &[
    ("motor-pos-cmd", "motor-pos-fb"),
    ("motor-pos-fb", "motor-pos-cmd"),
    ("step", "dir"),
    ("dir", "step"),
    ("up", "down"),
    ("down", "up"),
    ("position-cmd", "enable"),
    ("velocity-cmd", "enable"),
    ("command", "enable"),
    ("value", "enable"),
    ("enable", "value"),
    ("tool-prepare", "tool-prepared"),
    ("tool-prepared", "tool-prepare"),
    ("tool-change", "tool-changed"),
    ("tool-changed", "tool-change"),
    ("change", "changed"),
    ("changed", "change"),
    ("change", "number"),
    ("revs", "index-enable"),
    ("ok-in", "reset"),
];

impl Look<'_> {
    /// Reports connections of which one half is missing.
    pub(super) fn halves(&mut self) {
        for (ix, item) in self.items().iter().copied() {
            let Some((channel, last)) = item.name.as_str().rsplit_once('.') else { continue };
            for (_, needs) in PAIRS.iter().filter(|(has, _)| *has == last) {
                if let Some((other, missing)) = self.item(&format!("{channel}.{needs}")) {
                    self.half((ix, item), (other, missing));
                }
            }
        }
    }

    fn half(&mut self, (ix, item): (Ix, &Item), (other, missing): (Ix, &Item)) {
        if !item.direction.is_pin() || !missing.direction.is_pin() || !self.leads(ix, item) {
            return;
        }
        let answered = match self.graph.signal_of(other) {
            Some(_) => missing.direction == Direction::In || self.leads(other, missing),
            None => self.is_used(other) || missing.bits() & 0xff != 0,
        };
        if answered {
            return;
        }
        let (name, wanted) = (item.shown().as_str(), missing.shown().as_str());
        let text = format!("'{name}' is linked, and '{wanted}' is not connected");
        let remedy = if missing.direction == Direction::Out {
            format!("net SIGNAL {wanted} => PIN")
        } else {
            format!("net SIGNAL PIN => {wanted}")
        };
        let at = self.linked_at(ix);
        self.add(finding(Code::HalfWired, wanted, text).at(at).remedy(remedy));
    }

    /// Returns whether a pin is linked, and an output's signal has a reader.
    fn leads(&self, ix: Ix, item: &Item) -> bool {
        let Some(signal) = self.graph.signal_of(ix) else { return false };
        item.direction != Direction::Out || !self.ends(signal).1.is_empty()
    }
}
