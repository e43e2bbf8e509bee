//! The pins and signals of an instance.

use hal_protocol::{Direction, Kind, Link, Reply, Request, SignalInfo, Type, Value};
use std::collections::{BTreeMap, BTreeSet};

/// A pin or parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wired {
    pub(super) direction: Direction,
    pub(super) value: Value,
    pub(super) signal: Option<String>,
    pub(super) owner: String,
}

/// Pins, parameters, functions and signals by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wires {
    pub(super) pins: BTreeMap<String, Wired>,
    pub(super) signals: BTreeMap<String, SignalInfo>,
    pub(super) functs: BTreeSet<String>,
    /// Arguments with which components were loaded, by component.
    pub(super) args: BTreeMap<String, String>,
    /// First words of all names.
    firsts: BTreeSet<String>,
}

impl Wires {
    /// Reads them from an engine.
    pub(crate) fn of(link: &mut dyn Link) -> Self {
        let mut list = |kind, pattern: &str| {
            link.call(Request::List { kind, patterns: vec![pattern.to_owned()], ty: None })
        };
        // Pins of simulation are listed only when a pattern names them.
        let lists = [(Kind::Pins, "*"), (Kind::Pins, "*.sim.*"), (Kind::Params, "*")];
        let items = lists.map(|(kind, pattern)| match list(kind, pattern) {
            Ok(Reply::Items(items)) => items,
            _ => Vec::new(),
        });
        let (signals, functs) = (list(Kind::Signals, "*"), list(Kind::Functs, "*"));
        let components = list(Kind::Components, "*");
        let mut wires = Self::default();
        for item in items.into_iter().flatten() {
            let wired = Wired {
                direction: item.direction,
                value: item.value,
                signal: item.signal,
                owner: item.owner_name,
            };
            if let Some(original) = item.original {
                wires.pins.insert(original, wired.clone());
            }
            wires.pins.insert(item.name, wired);
        }
        if let Ok(Reply::Signals(signals)) = signals {
            wires.signals = signals.into_iter().map(|s| (s.name.clone(), s)).collect();
        }
        if let Ok(Reply::Components(components)) = components {
            let args = components.into_iter().filter_map(|c| Some((c.name, c.args?)));
            wires.args = args.collect();
        }
        if let Ok(Reply::Functs(functs)) = functs {
            wires.functs = functs.into_iter().map(|f| f.name).collect();
        }
        let names = wires.pins.keys().chain(&wires.functs);
        wires.firsts = names.map(|name| first(name).to_owned()).collect();
        wires
    }

    /// Returns whether no name begins with the first word of this one.
    pub(super) fn is_foreign(&self, name: &str) -> bool {
        name.contains('.') && !self.firsts.contains(first(name))
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.pins.contains_key(name) || self.functs.contains(name)
    }

    /// Returns the pin that writes a signal.
    pub(super) fn writer(&self, signal: &str) -> Option<&str> {
        let pins = &self.signals.get(signal)?.pins;
        pins.iter().find(|(dir, _)| *dir == Direction::Out).map(|(_, name)| name.as_str())
    }

    /// Returns the signal of a pin.
    pub(super) fn signal_of(&self, pin: &str) -> Option<&str> {
        self.pins.get(pin)?.signal.as_deref()
    }

    pub(super) fn type_of(&self, pin: &str) -> Option<Type> {
        self.pins.get(pin).map(|pin| pin.value.ty())
    }
}

fn first(name: &str) -> &str {
    name.split('.').next().unwrap_or(name)
}
