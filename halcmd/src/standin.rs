//! Stand-ins: pins in place of components that are not there, so that a machine can be tried without its hardware and
//! without its screen.
//!
//! A dry run of all lines tells what is missing ([`Facts`]). [`StandIns::of`] decides what of it is replaced
//! ([`Asked`]) and which pins and functions that has, with their types and directions ([`infer`]). The component
//! `standin` makes them. When the files have been executed, [`StandIns::settle`] sets the values of a machine at rest
//! ([`healthy`]). On the real clock values stay 0, and a stand-in that motion depends on is refused ([`reach`]).

mod asked;
mod healthy;
mod infer;
mod known;
mod names;
mod reach;
mod settle;
#[cfg(test)]
mod tests;
mod wires;

pub(crate) use asked::Asked;
pub(crate) use known::{is_named_in, is_view};
pub(crate) use wires::Wires;

use hal_protocol::{At, Request};
use infer::{Inferred, Pin};
use std::collections::BTreeSet;

/// Returns the beginnings of the names that a module or program of this name makes, as far as they are known.
pub(crate) fn pins_of(name: &str) -> &'static [&'static str] {
    known::find(name).map_or(&[], |known| known.pins)
}

/// Returns whether a module or program of this name is known to drive hardware or to show something.
pub(crate) fn is_known(name: &str) -> bool {
    known::find(name).is_some()
}

/// Returns whether a module or program of this name drives hardware.
pub(crate) fn drives_hardware(name: &str) -> bool {
    known::find(name).is_some_and(|known| known.kind != known::PartKind::Screen)
}

/// Returns whether a program of this name shows something.
pub(crate) fn is_screen(name: &str) -> bool {
    is_view(name) || known::find(name).is_some_and(|known| known.kind == known::PartKind::Screen)
}

/// Extent of the simulation in a start of a machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each follows from an option of its own")]
pub(crate) struct Start {
    /// Hardware is simulated: the stand-ins have values.
    pub(crate) simulated: bool,
    /// Inputs of simulated ports that nobody has set are those of a machine at rest.
    pub(crate) ports: bool,
    /// Joints whose home switches nobody writes are homed where they stand.
    pub(crate) homes: bool,
    /// True if no screen is shown, so that the programs of its files are not started.
    pub(crate) headless: bool,
}

/// Facts from a dry run of a machine's lines.
pub(crate) struct Facts<'a> {
    /// Modules and programs whose names are not known; whether each is a screen, and whether it names a device.
    pub(crate) makers: Vec<(&'a str, bool, bool)>,
    /// Modules and programs whose names lines use.
    pub(crate) used: BTreeSet<&'a str>,
    /// Modules and programs that lines load or start.
    pub(crate) loaded: &'a BTreeSet<String>,
    /// Loaded modules and programs that are not there.
    pub(crate) absent: &'a BTreeSet<String>,
    /// The words of each line.
    pub(crate) statements: &'a [(At, Vec<String>)],
    /// Returns the module or program that may make a name.
    pub(crate) maker: &'a dyn Fn(&str) -> Option<&'a str>,
}

/// Pins and functions of a machine in place of what it has not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct StandIns {
    /// Modules and programs whose lines load nothing.
    replaced: BTreeSet<String>,
    /// Names that were asked for and that no line loads.
    idle: BTreeSet<String>,
    /// Modules and programs that are not there and are not replaced.
    pub(crate) missing: BTreeSet<String>,
    inferred: Inferred,
    start: Start,
}

impl StandIns {
    /// Decides what is replaced, and finds the pins of that.
    pub(crate) fn of(facts: &Facts<'_>, wires: &Wires, asked: &Asked) -> Self {
        let (mut replaced, mut missing) = (BTreeSet::new(), BTreeSet::new());
        for (name, is_screen, names_device) in &facts.makers {
            let is_absent = facts.absent.contains(*name);
            let is_replaced = asked.replaces(name, is_absent)
                || *is_screen && asked.is_headless()
                || *names_device && asked.is_simulated();
            if is_replaced && (facts.loaded.contains(*name) || facts.used.contains(name)) {
                replaced.insert((*name).to_owned());
            } else if is_absent && !is_replaced {
                missing.insert((*name).to_owned());
            }
        }
        let is_there = |name: &&str| facts.loaded.contains(*name) || facts.used.contains(name);
        let idle = asked.names().filter(|name| !is_there(name)).map(str::to_owned).collect();
        replaced.extend(asked.names().filter(is_there).map(str::to_owned));
        let inferred = infer::infer(facts.statements, wires, |name| match (facts.maker)(name) {
            Some(maker) => replaced.contains(maker),
            None => asked.takes_all() && wires.is_foreign(name),
        });
        Self { replaced, idle, missing, inferred, start: Start::default() }
    }

    /// Returns the stand-ins for a start that simulates this.
    pub(crate) fn with(self, start: Start) -> Self {
        Self { start, ..self }
    }

    /// Returns whether hardware is simulated.
    pub(crate) const fn is_simulated(&self) -> bool {
        self.start.simulated
    }

    /// Returns whether no screen is shown.
    pub(crate) const fn is_headless(&self) -> bool {
        self.start.headless
    }

    /// Returns the modules and programs that are replaced.
    fn replaced_names(&self) -> impl Iterator<Item = &str> {
        self.replaced.iter().map(String::as_str)
    }

    /// Returns whether the lines that load this module or start this program do nothing.
    pub(crate) fn replaces(&self, name: &str) -> bool {
        self.replaced.contains(name)
    }

    /// Returns whether there are no pins.
    pub(crate) fn is_empty(&self) -> bool {
        self.inferred.pins.is_empty() && self.inferred.functs.is_empty()
    }

    /// Returns the request that makes the pins.
    pub(crate) fn load(&self) -> Option<Request> {
        let args = self.inferred.arguments();
        (!self.is_empty()).then(|| Request::Load { module: "standin".to_owned(), args })
    }

    /// Returns what is replaced and which pins are doubtful, in sentences.
    pub(crate) fn notes(&self) -> Vec<String> {
        let idle = |name| format!("--stub {name}: no line loads or starts it");
        let mut notes: Vec<String> = self.idle.iter().map(idle).collect();
        if !self.replaced.is_empty() {
            let names: Vec<&str> = self.replaced_names().collect();
            let functs = match self.inferred.functs.len() {
                0 => String::new(),
                n => format!(" and {}", counted(n, "function")),
            };
            let pins = counted(self.inferred.pins.len(), "pin");
            let values = if self.start.simulated { "" } else { "; they stay 0 and FALSE" };
            notes.push(format!("stand-ins for {}: {pins}{functs}{values}", names.join(", ")));
        }
        let doubtful: Vec<&str> = self.inferred.doubtful().collect();
        if let Some(first) = doubtful.first() {
            let more = match doubtful.len() {
                1 => String::new(),
                n => format!(" and {} more", n - 1),
            };
            notes.push(format!(
                "the files do not tell type and direction of stand-in pin '{first}'{more}"
            ));
        }
        if !self.start.simulated {
            let pins = self.inferred.pins.iter().map(Pin::shown);
            notes.extend(pins.map(|pin| format!("stand-in pin {pin}")));
        }
        notes
    }
}

fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
