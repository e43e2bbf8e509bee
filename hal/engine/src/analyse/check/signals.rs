//! Checks of signals without writers, readers or pins.

use super::{Look, finding, names};
use crate::graph::{Item, Ix};
use hal_protocol::{Code, Finding};

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
            // Exchanged letters are an error; one letter more or another one may be another name.
            let surely = is_exchange(own.name.as_str(), name.as_str())
                || is_inside_word(own.name.as_str(), name.as_str());
            !needed.is_empty() && (extra.is_empty() || surely)
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
        found.code = Code::SignalMisspelt;
        found.level = Code::SignalMisspelt.level();
        found.remedy = format!("did you mean '{meant}'?");
    }
    found
}

/// Characters between the words of a name.
const BETWEEN: [u8; 3] = [b'-', b'_', b'.'];
/// Letters of axes, in which the names of two signals may differ.
const AXES: &[u8] = b"xyzabcuvw";

/// Returns the rest of two names, the shorter first, from the first byte in which they differ, and the number of
/// bytes before it.
fn rests<'a>(a: &'a str, b: &'a str) -> (&'a [u8], &'a [u8], usize) {
    let (a, b) = if a.len() <= b.len() { (a, b) } else { (b, a) };
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let same = a.iter().zip(b).take_while(|(a, b)| a == b).count();
    (a.get(same..).unwrap_or_default(), b.get(same..).unwrap_or_default(), same)
}

/// Returns whether two names differ in two neighbouring letters that are exchanged.
fn is_exchange(a: &str, b: &str) -> bool {
    match rests(a, b) {
        (_, _, 0) => false,
        ([x, y, rest @ ..], [p, q, others @ ..], _) => x == q && y == p && rest == others,
        _ => false,
    }
}

/// Returns whether two names differ by one typing error: two letters exchanged, one letter too many or too few, or
/// another letter inside a longer word. Names that differ as those of two axes do are different names.
fn is_typing_error(a: &str, b: &str) -> bool {
    if is_exchange(a, b) || is_inside_word(a, b) {
        return true;
    }
    match rests(a, b) {
        (_, _, 0) => false,
        // 'change' and 'changed', 'limit' and 'limits' are two words.
        ([], [b'd' | b's'], same) if !doubles(a, b, same) => false,
        (rest, [letter, others @ ..], _) => rest == others && letter.is_ascii_alphabetic(),
        _ => false,
    }
}

/// Returns whether the letter in which two names begin to differ doubles the one before it.
fn doubles(a: &str, b: &str, same: usize) -> bool {
    let longer = if a.len() <= b.len() { b } else { a }.as_bytes();
    same.checked_sub(1).is_some_and(|before| longer.get(before) == longer.get(same))
}

/// Returns whether two names differ by one letter, neither the first nor the last of a word of five letters or more,
/// that is too many or another one, and is not the letter of an axis.
fn is_inside_word(a: &str, b: &str) -> bool {
    let (short, long, same) = rests(a, b);
    let longer = if a.len() <= b.len() { b } else { a }.as_bytes();
    let (Some(letter), Some(others)) = (long.first(), long.get(1..)) else { return false };
    let replaced = short.first().filter(|_| short.get(1..) == Some(others));
    let is_plain =
        |letter: &u8| letter.is_ascii_alphabetic() && !AXES.contains(&letter.to_ascii_lowercase());
    if !is_plain(letter) || replaced.map_or(short != others, |other| !is_plain(other)) {
        return false;
    }
    let is_end = |b: &u8| BETWEEN.contains(b) || b.is_ascii_digit();
    let before = longer.get(..same).unwrap_or_default().iter().rev().take_while(|b| !is_end(b));
    let after = others.iter().take_while(|b| !is_end(b));
    let (before, after) = (before.count(), after.count());
    0 < before && 0 < after && before + after >= 4
}

#[cfg(test)]
mod tests {
    use super::{is_inside_word, is_typing_error};

    #[test]
    fn typing_errors_are_near_and_two_axes_are_not() {
        for (a, b) in [("estop-out", "estop-otu"), ("heigth", "height"), ("x-cmd", "x-cmdd")] {
            assert!(is_typing_error(a, b) && is_typing_error(b, a), "{a} {b}");
        }
        for (a, b) in
            [("spindle-on", "spindke-on"), ("enable", "enble"), ("estop-out", "etsop-out")]
        {
            assert!(is_typing_error(a, b) && is_typing_error(b, a), "{a} {b}");
        }
        for (a, b) in [
            ("homex", "homey"),
            ("axisx-cmd", "axisy-cmd"),
            ("limit1-in", "limit2-in"),
            ("change", "changed"),
        ] {
            assert!(!is_typing_error(a, b) && !is_inside_word(a, b), "{a} {b}");
        }
        for (a, b) in [
            ("x-cmd", "y-cmd"),
            ("x-cmd", "x-cmd"),
            ("in-1", "in-12"),
            ("ab", "abcd"),
            ("spindle-on", "spindle-no2"),
        ] {
            assert!(!is_typing_error(a, b) && !is_typing_error(b, a), "{a} {b}");
        }
    }
}
