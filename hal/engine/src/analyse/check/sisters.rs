//! Checks of channels of one kind: one that lacks what all others have, and links to another
//! channel than the rest.

use super::{Look, finding};
use crate::graph::Ix;
use hal_protocol::{Code, Direction};
use std::collections::{BTreeMap, BTreeSet};

/// Families whose channels serve one joint or motor each.
const FAMILIES: &[&str] = &["joint", "axis", "stepgen", "encoder", "pwmgen", "pid", "debounce"];
/// Pins by which a joint is linked to its motor.
const MOTOR: &[&str] = &["motor-pos-cmd", "motor-pos-fb", "amp-enable-out"];

/// Use of a pin or parameter.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Used {
    No,
    Linked,
    Set,
}

/// Tails of one family, and how each channel uses them.
type Tails<'g> = BTreeMap<&'g str, BTreeMap<u32, (Ix, Used)>>;

/// Splits a name at its channel number: `stepgen.0.step` into `stepgen`, 0, `step`.
fn split(name: &str) -> Option<(&str, u32, &str)> {
    let digits = |part: &str| part.parse::<u32>().ok();
    let mut dots = name.rmatch_indices('.').map(|(at, _)| at);
    let mut end = dots.next()?;
    for start in dots {
        if let Some(n) = name.get(start + 1..end).and_then(digits) {
            return Some((name.get(..start)?, n, name.get(end + 1..)?));
        }
        end = start;
    }
    None
}

fn is_family(head: &str) -> bool {
    let first = head.split('.').next().unwrap_or_default();
    FAMILIES.contains(&first) || first.starts_with("hm2_")
}

impl<'g> Look<'g> {
    /// Reports channels that differ from all others of their kind.
    pub(super) fn sisters(&mut self) {
        let mut families: BTreeMap<&str, Tails<'g>> = BTreeMap::new();
        for (ix, item) in self.items().iter().copied() {
            let Some((head, n, tail)) = split(item.name.as_str()) else { continue };
            if !is_family(head) || item.direction == Direction::Ro {
                continue;
            }
            let used = match self.graph.signal_of(ix) {
                Some(_) => Used::Linked,
                None if self.is_used(ix) => Used::Set,
                None => Used::No,
            };
            families.entry(head).or_default().entry(tail).or_default().insert(n, (ix, used));
        }
        for tails in families.values() {
            // Every joint of a machine is in use.
            let joints = tails.get("motor-pos-cmd");
            let mut active: BTreeSet<u32> =
                joints.map(|j| j.keys().copied().collect()).unwrap_or_default();
            if tails.values().all(|c| c.values().all(|c| c.1 == Used::No)) {
                continue;
            }
            for channels in tails.values() {
                active.extend(channels.iter().filter(|(_, c)| c.1 != Used::No).map(|(n, _)| *n));
            }
            for (tail, channels) in tails {
                self.odd_one(tail, channels, &active);
            }
        }
        self.crossed_motors();
        self.crossed_names();
    }

    fn odd_one(&mut self, tail: &str, all: &BTreeMap<u32, (Ix, Used)>, active: &BTreeSet<u32>) {
        let of = |n: &u32| all.get(n).map_or(Used::No, |c| c.1);
        let (without, with): (Vec<u32>, Vec<u32>) = active.iter().partition(|n| of(n) == Used::No);
        let ([odd], [first, rest @ ..]) = (without.as_slice(), with.as_slice()) else { return };
        let same = rest.iter().all(|n| of(n) == of(first));
        let few = rest.is_empty() && of(first) != Used::Set;
        // The last joint of a machine is often one without switches.
        let switch = tail.ends_with("-sw-in") && Some(odd) == active.last();
        let (Some((ix, _)), Some((other, _))) = (all.get(odd), all.get(first)) else { return };
        if !same || few || switch {
            return;
        }
        let (name, example) = (self.shown(*ix), self.shown(*other));
        let (how, remedy) = if of(first) == Used::Set {
            ("set", format!("setp {name} VALUE"))
        } else if self.graph.item(*ix).is_some_and(|i| i.direction == Direction::Out) {
            ("linked", format!("net SIGNAL {name} => PIN"))
        } else {
            ("linked", format!("net SIGNAL PIN => {name}"))
        };
        let others = if rest.is_empty() { "" } else { ", as in every other channel in use" };
        let text = format!("'{name}' is not {how}, and '{example}' is{others}");
        let there = self.linked_at(*other).or_else(|| self.set_at(*other));
        let at = self.loaded_at(*ix);
        self.add(
            finding(Code::OddChannel, name, text)
                .at(at)
                .remedy(remedy)
                .related(there, format!("'{example}' is {how} here")),
        );
    }

    /// Reports joints whose command, feedback and enable go to different channels of one family.
    fn crossed_motors(&mut self) {
        for (command, item) in self.items().iter().copied() {
            let Some((head, n, tail)) = split(item.name.as_str()) else { continue };
            if !matches!(head, "joint" | "axis") || tail != "motor-pos-cmd" {
                continue;
            }
            let to = self.channels_at(command);
            for other in MOTOR.iter().skip(1) {
                let Some((pin, item)) = self.item(&format!("{head}.{n}.{other}")) else { continue };
                self.crossed_joint(pin, (head, n));
                for (family, from) in self.channels_at(pin) {
                    let Some(commanded) = to.get(family).filter(|c| c.is_disjoint(&from)) else {
                        continue;
                    };
                    let name = item.shown().as_str();
                    let (a, b) = (list(family, &from), list(family, commanded));
                    let text = format!(
                        "'{name}' is linked to {a}, and '{}' to {b}: they are crossed",
                        self.shown(command)
                    );
                    let (at, there) = (self.linked_at(pin), self.linked_at(command));
                    self.add(
                        finding(Code::Crossed, name, text)
                            .at(at)
                            .remedy(format!("link both '{name}' and '{}' to one channel", {
                                self.shown(command)
                            }))
                            .related(there, format!("'{}' is linked here", self.shown(command))),
                    );
                }
            }
        }
    }

    /// Reports feedback of a joint that is the command of another one.
    fn crossed_joint(&mut self, pin: Ix, (head, n): (&str, u32)) {
        let Some(signal) = self.graph.signal_of(pin) else { return };
        let pins = self.graph.pins_of(signal);
        let other = pins.into_iter().find(|p| {
            let name = self.graph.item(*p).and_then(|i| split(i.name.as_str()));
            name.is_some_and(|(h, m, tail)| h == head && m != n && tail == "motor-pos-cmd")
        });
        let Some(other) = other else { return };
        let (name, there) = (self.shown(pin), self.shown(other));
        let text = format!("'{name}' is linked to '{there}' of another joint: they are crossed");
        let (at, related) = (self.linked_at(pin), self.linked_at(other));
        self.add(
            finding(Code::Crossed, name, text)
                .at(at)
                .remedy(format!("link '{name}' to '{head}.{n}.motor-pos-cmd'"))
                .related(related, format!("'{there}' is linked here")),
        );
    }

    /// Returns the channels of other families that share a pin's signal.
    fn channels_at(&self, pin: Ix) -> BTreeMap<&'g str, BTreeSet<u32>> {
        let channels = self.graph.signal_of(pin).map(|signal| self.channels_of(signal));
        let others = channels.into_iter().flatten();
        others
            .filter(|(family, _)| !matches!(*family, "joint" | "axis"))
            .map(|(family, channels)| (family, channels.into_keys().collect()))
            .collect()
    }

    /// Returns the channels that a signal is linked to, by family, each with one of its pins.
    fn channels_of(&self, signal: Ix) -> BTreeMap<&'g str, BTreeMap<u32, Ix>> {
        let mut found: BTreeMap<&str, BTreeMap<u32, Ix>> = BTreeMap::new();
        for pin in self.graph.pins_of(signal) {
            let Some(item) = self.graph.item(pin) else { continue };
            if let Some((head, n, _)) = split(item.name.as_str()).filter(|c| is_family(c.0)) {
                found.entry(head).or_default().insert(n, pin);
            }
        }
        found
    }

    /// Reports a signal that is linked to another channel than all other signals with the same
    /// beginning of their names.
    fn crossed_names(&mut self) {
        // By the beginning of the name and the family: each signal with its channels.
        type Signals = Vec<(Ix, BTreeMap<u32, Ix>)>;
        let mut stems: BTreeMap<(&str, &str), Signals> = BTreeMap::new();
        for (name, signal) in self.graph.signal_names() {
            let Some((stem, _)) = name.as_str().split_once(['-', '_', '.']) else { continue };
            for (family, channels) in self.channels_of(signal) {
                stems.entry((stem, family)).or_default().push((signal, channels));
            }
        }
        for ((stem, family), signals) in stems {
            // Signals that join several channels say nothing about one.
            if signals.len() < 3 || signals.iter().any(|(_, c)| c.len() != 1) {
                continue;
            }
            for (signal, channels) in &signals {
                let mut others = signals.iter().filter(|(s, _)| s != signal).map(|(_, c)| c);
                let Some(first) = others.next() else { continue };
                let mut common: BTreeSet<u32> = first.keys().copied().collect();
                for other in others {
                    common.retain(|n| other.contains_key(n));
                }
                let (Some(n), Some((odd, pin))) = (common.first(), channels.iter().next()) else {
                    continue;
                };
                if common.iter().any(|n| channels.contains_key(n)) {
                    continue;
                }
                let (name, shown) = (self.signal_name(*signal), self.shown(*pin));
                let right =
                    shown.replacen(&format!("{family}.{odd}."), &format!("{family}.{n}."), 1);
                let text = format!(
                    "signal '{name}' is linked to '{shown}', and the other signals that begin with \
                     '{stem}' to '{family}.{n}'"
                );
                let at = self.linked_at(*pin);
                self.add(
                    finding(Code::Crossed, name, text)
                        .at(at)
                        .remedy(format!("link '{right}' to it, if the two are crossed")),
                );
            }
        }
    }
}

fn list(family: &str, channels: &BTreeSet<u32>) -> String {
    let all: Vec<String> = channels.iter().map(|n| format!("'{family}.{n}'")).collect();
    all.join(" and ")
}
