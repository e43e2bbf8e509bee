//! Checks of signals without writers, readers or pins.

use super::{Look, finding, names};
use crate::graph::{Item, Ix};
use hal_protocol::{Code, Finding, Level};

impl<'g> Look<'g> {
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
            let found = finding(Code::NoReader, name, text)
                .at(at)
                .remedy(format!("link an input to it: net {name} => PIN"));
            let meant = self.meant(signal, true);
            self.add(misspelt(found, meant));
        } else if writers.is_empty() && !self.is_constant(signal, &readers) {
            let guards = readers.iter().any(|r| self.graph.item(*r).is_some_and(Item::safety));
            let then = if guards { ": it never protects anything" } else { "" };
            let text =
                format!("nothing writes signal '{name}', which {} reads{then}", list(&readers));
            let at = readers.first().and_then(|pin| self.linked_at(*pin));
            let found = finding(Code::NoWriter, name, text).at(at).remedy(format!(
                "link an output to it: net {name} <= PIN; or give it a value: sets {name} VALUE"
            ));
            let meant = self.meant(signal, false);
            self.add(misspelt(found, meant));
        }
    }

    /// Returns another signal of the same type, whose name differs by a typing error and which has
    /// readers if `is_written`, otherwise writers.
    fn meant(&self, signal: Ix, is_written: bool) -> Option<&'g str> {
        let own = self.graph.signal(signal)?;
        let mut others = self.graph.signal_names().into_iter().filter(|(name, other)| {
            let is_alike = self.graph.signal(*other).is_some_and(|o| o.ty == own.ty)
                && is_typing_error(own.name.as_str(), name.as_str());
            if !is_alike {
                return false;
            }
            let (writers, readers) = self.ends(*other);
            let (needed, extra) = if is_written { (readers, writers) } else { (writers, readers) };
            // Exchanged letters are an error; one letter more may be another name.
            let same = own.name.as_str().len() == name.as_str().len();
            !needed.is_empty() && (extra.is_empty() || same)
        });
        others.next().map(|(name, _)| name.as_str())
    }

    /// Returns whether a script line has given the signal, or a pin linked to it, a constant value.
    fn is_constant(&self, signal: Ix, pins: &[Ix]) -> bool {
        let set = |node: Ix| self.graph.sites.values_of(node).is_some();
        set(signal) || pins.iter().any(|pin| set(*pin))
    }
}

/// Makes a finding about a signal with one end a warning, if its name is probably misspelt.
fn misspelt(mut found: Finding, meant: Option<&str>) -> Finding {
    if let Some(meant) = meant {
        found.level = Level::Warning;
        found.remedy = format!("did you mean '{meant}'?");
    }
    found
}

/// Returns whether two names differ by one typing error: two letters exchanged, or one letter too
/// many or too few. Names that differ in one letter, as those of two axes do, are different names.
fn is_typing_error(a: &str, b: &str) -> bool {
    let (a, b) = if a.len() <= b.len() {
        (a.as_bytes(), b.as_bytes())
    } else {
        (b.as_bytes(), a.as_bytes())
    };
    let same = a.iter().zip(b).take_while(|(a, b)| a == b).count();
    let (Some(a), Some(b)) = (a.get(same..), b.get(same..)) else { return false };
    if same == 0 {
        return false;
    }
    match (a, b) {
        ([x, y, rest @ ..], [p, q, others @ ..]) if x == q && y == p && rest == others => true,
        (rest, [letter, others @ ..]) => rest == others && letter.is_ascii_alphabetic(),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::is_typing_error;

    #[test]
    fn typing_errors_are_near_and_two_axes_are_not() {
        for (a, b) in [("estop-out", "estop-otu"), ("heigth", "height"), ("x-cmd", "x-cmdd")] {
            assert!(is_typing_error(a, b) && is_typing_error(b, a), "{a} {b}");
        }
        for (a, b) in [("x-cmd", "y-cmd"), ("x-cmd", "x-cmd"), ("in-1", "in-12"), ("ab", "abcd")] {
            assert!(!is_typing_error(a, b) && !is_typing_error(b, a), "{a} {b}");
        }
    }
}
