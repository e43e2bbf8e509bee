//! Checks of protection for people and machine: limits, e-stop, outputs, charge pump.

use super::{Look, finding, names};
use crate::graph::{Component, Item, Ix};
use hal_protocol::{Code, Direction, Type};
use std::collections::{BTreeMap, BTreeSet};

/// Suffix of the input that lets the machine leave e-stop.
const ENABLE: &str = ".emc-enable-in";
/// Most outputs of a component that are reported one by one: those of a parallel port.
const MOST: usize = 16;
/// Suffix of the pin by which the driver of a card with a watchdog reports a bite, as LinuxCNC's does.
const WATCHDOG: &str = ".watchdog.has_bit";
/// Beginning of the name of a card's line, behind the last dot: its other inputs set how it works.
const OUT: &str = "out";
/// Name of the parameter beside a line that makes it an output.
const IS_OUTPUT: &str = "is_output";

impl Look<'_> {
    pub(super) fn protection(&mut self) {
        self.guards();
        self.outputs();
    }

    /// Reports limit switch and e-stop inputs that are not linked.
    fn guards(&mut self) {
        let mut idle: BTreeMap<Ix, Vec<&str>> = BTreeMap::new();
        for (ix, item) in self.items().iter().copied() {
            if !item.safety() || !self.is_idle(ix) {
                continue;
            }
            if item.name.as_str().ends_with(ENABLE) && item.bits() & 0xff == 0 {
                let name = item.shown().as_str();
                let text = format!("'{name}' is not linked and FALSE: e-stop is never reset");
                let at = self.loaded_at(ix);
                let out = name.replace(ENABLE, ".user-enable-out");
                self.add(
                    finding(Code::NeverEnabled, name, text)
                        .at(at)
                        .remedy(format!("net estop-loop {out} => {name}")),
                );
            } else if let Some(owner) = self.graph.owner_of(ix) {
                idle.entry(owner).or_default().push(item.shown().as_str());
            }
        }
        for (owner, pins) in idle {
            let Some(component) = self.graph.component(owner) else { continue };
            let name = component.name.as_str();
            let text = match pins.len() {
                1 => format!("{} is not linked: it protects nothing", names(pins)),
                _ => format!("not linked, and so without effect: {}", names(pins)),
            };
            let at = self.graph.sites.of(owner);
            self.add(
                finding(Code::Unguarded, name, text)
                    .at(at)
                    .remedy("link the switches that the machine has: net SIGNAL PIN => PIN"),
            );
        }
    }

    /// Reports driver outputs that no signal feeds, and outputs without a charge pump.
    fn outputs(&mut self) {
        let items = self.items();
        let watched = items.iter().filter(|(_, item)| item.name.as_str().ends_with(WATCHDOG));
        let cards: BTreeSet<Ix> = watched.filter_map(|(ix, _)| self.graph.owner_of(*ix)).collect();
        let mut driven = None;
        let mut unfed: BTreeMap<Ix, Vec<&str>> = BTreeMap::new();
        for (ix, item) in items.iter().copied() {
            let Some(owner) = self.graph.owner_of(ix) else { continue };
            if !self.graph.component(owner).is_some_and(is_driver)
                || item.direction != Direction::In
                || !matches!(item.ty, Type::Bit | Type::Float)
            {
                continue;
            }
            if self.graph.signal_of(ix).is_some() {
                // The watchdog of a card does what a charge pump would.
                if !cards.contains(&owner) {
                    driven.get_or_insert(owner);
                }
            } else if self.is_idle(ix) && (!cards.contains(&owner) || self.is_line(item)) {
                unfed.entry(owner).or_default().push(item.shown().as_str());
            }
        }
        for (owner, pins) in unfed {
            // A card has more lines than most machines wire.
            let most = if cards.contains(&owner) { 1 } else { MOST };
            self.unfed(owner, &pins, most);
        }
        let pumps =
            self.graph.funct_names().iter().any(|(f, _)| f.as_str().starts_with("charge-pump"));
        let Some(owner) = driven.filter(|_| !pumps) else { return };
        let Some(component) = self.graph.component(owner) else { return };
        let name = component.name.as_str();
        let at = self.graph.sites.of(owner);
        self.add(
            finding(Code::NoChargePump, name, format!("the outputs of {name} have no charge pump"))
                .at(at)
                .remedy(
                    "if the board has an input for one: loadrt charge_pump, addf charge-pump to \
                     the fastest thread, net pump charge-pump.out => PIN",
                ),
        );
    }
}

impl Look<'_> {
    /// Returns whether an input of a card is a line, and one that its parameter makes an output.
    fn is_line(&self, item: &Item) -> bool {
        let name = item.name.as_str();
        let Some((line, _)) = name.rsplit_once('.').filter(|(_, last)| last.starts_with(OUT))
        else {
            return false;
        };
        let parameter = self.item(&format!("{line}.{IS_OUTPUT}"));
        parameter.is_none_or(|(_, is_output)| is_output.bits() & 0xff != 0)
    }

    /// Reports outputs of a component that no signal feeds: one by one, or more than `most` as one.
    fn unfed(&mut self, owner: Ix, pins: &[&str], most: usize) {
        if pins.len() > most {
            let Some(component) = self.graph.component(owner) else { return };
            let at = self.graph.sites.of(owner);
            let text =
                format!("no signal feeds {} outputs: {}", pins.len(), names(pins.iter().copied()));
            self.add(
                finding(Code::Unfed, component.name.as_str(), text)
                    .at(at)
                    .remedy("net SIGNAL PIN => PIN for those to which something is wired"),
            );
            return;
        }
        for name in pins {
            let at = self.graph.sites.of(owner);
            self.add(
                finding(Code::Unfed, name, format!("no signal feeds output '{name}'"))
                    .at(at)
                    .remedy(format!("net SIGNAL PIN => {name}, if something is wired to it")),
            );
        }
    }
}

/// Returns whether a component drives hardware lines, which is so if it declares a stop action.
/// Components that are not plugins do not count, because nothing is known about them.
pub(super) fn is_driver(component: &Component) -> bool {
    component.foreign.is_none() && !component.stops.is_empty()
}
