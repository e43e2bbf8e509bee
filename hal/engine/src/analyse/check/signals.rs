//! Checks of signals without writers, readers or pins.

use super::{Look, finding, names};
use crate::graph::{Item, Ix};
use hal_protocol::Code;

impl Look<'_> {
    pub(super) fn signals(&mut self) {
        for (_, signal) in self.graph.signal_names() {
            self.ends_of(signal);
        }
    }

    fn ends_of(&mut self, signal: Ix) {
        let name = self.signal_name(signal);
        let (writers, readers) = self.ends(signal);
        let list = |pins: &[Ix]| names(pins.iter().map(|pin| self.shown(*pin)));
        if writers.is_empty() && readers.is_empty() {
            let text = format!("signal '{name}' has no pins");
            let at = self.graph.sites.of(signal);
            self.add(
                finding(Code::NoPins, name, text)
                    .at(at)
                    .remedy(format!("link pins to it: net {name} PIN => PIN; or remove it")),
            );
        } else if readers.is_empty() {
            let text = format!("nothing reads signal '{name}', which {} writes", list(&writers));
            let at = writers.first().and_then(|pin| self.linked_at(*pin));
            self.add(
                finding(Code::NoReader, name, text)
                    .at(at)
                    .remedy(format!("link an input to it: net {name} => PIN")),
            );
        } else if writers.is_empty() && !self.is_constant(signal, &readers) {
            let guards = readers.iter().any(|r| self.graph.item(*r).is_some_and(Item::safety));
            let then = if guards { ": it never protects anything" } else { "" };
            let text =
                format!("nothing writes signal '{name}', which {} reads{then}", list(&readers));
            let at = readers.first().and_then(|pin| self.linked_at(*pin));
            self.add(finding(Code::NoWriter, name, text).at(at).remedy(format!(
                "link an output to it: net {name} <= PIN; or give it a value: sets {name} VALUE"
            )));
        }
    }

    /// Returns whether a script line has given the signal, or a pin linked to it, a constant value.
    fn is_constant(&self, signal: Ix, pins: &[Ix]) -> bool {
        let set = |node: Ix| self.graph.sites.values_of(node).is_some();
        set(signal) || pins.iter().any(|pin| set(*pin))
    }
}
