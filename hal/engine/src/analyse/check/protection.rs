//! Checks of protection for people and machine: limits, e-stop, outputs, charge pump.

use super::{Look, finding, names};
use crate::graph::{Component, Ix};
use hal_protocol::{Code, Direction, Type};
use std::collections::BTreeMap;

/// Suffix of the input that lets the machine leave e-stop.
const ENABLE: &str = ".emc-enable-in";

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
        let mut driven = None;
        for (ix, item) in self.items().iter().copied() {
            let Some(owner) = self.graph.owner_of(ix) else { continue };
            if !self.graph.component(owner).is_some_and(is_driver)
                || item.direction != Direction::In
                || !matches!(item.ty, Type::Bit | Type::Float)
            {
                continue;
            }
            if self.graph.signal_of(ix).is_some() {
                driven.get_or_insert(owner);
            } else if self.is_idle(ix) {
                let name = item.shown().as_str();
                let at = self.graph.sites.of(owner);
                self.add(
                    finding(Code::Unfed, name, format!("no signal feeds output '{name}'"))
                        .at(at)
                        .remedy(format!("net SIGNAL PIN => {name}, if something is wired to it")),
                );
            }
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

/// Returns whether a component drives hardware lines, which is so if it declares a stop action.
/// Components that are not plugins do not count, because nothing is known about them.
pub(super) fn is_driver(component: &Component) -> bool {
    component.foreign.is_none() && !component.stops.is_empty()
}
