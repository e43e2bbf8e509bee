//! Request for stand-ins.

use super::known::{self, PartKind};
use crate::ini::Ini;
use std::collections::BTreeSet;

/// Word of `--stub` for everything that is not there.
pub(crate) const MISSING: &str = "missing";

/// Request for stand-ins, of a person and of the kind of start.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Asked {
    names: BTreeSet<String>,
    /// True to replace everything that is not there.
    all: bool,
    simulated: bool,
    /// True if no screen is shown.
    headless: bool,
}

impl Asked {
    /// Makes the request of the names in `--stub` and `[HAL]STUB`, separated by commas or spaces.
    pub(crate) fn of<'a>(
        texts: impl Iterator<Item = &'a str>,
        simulated: bool,
        headless: bool,
    ) -> Self {
        let words = texts.flat_map(|text| text.split([',', ' ', '\t']));
        let mut names: BTreeSet<String> =
            words.filter(|word| !word.is_empty()).map(str::to_owned).collect();
        let all = names.remove(MISSING);
        Self { names, all, simulated, headless }
    }

    /// Makes the request of an INI file's `[HAL]STUB`.
    pub(crate) fn of_ini(ini: &Ini, simulated: bool, headless: bool) -> Self {
        let entries = ini.all("HAL", "STUB").map(|entry| entry.value.as_str());
        Self::of(entries, simulated, headless)
    }

    /// Returns whether a person asked for stand-ins.
    pub(crate) fn is_explicit(&self) -> bool {
        self.all || !self.names.is_empty()
    }

    /// Returns the names that a person gave.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    pub(super) const fn takes_all(&self) -> bool {
        self.all
    }

    /// Returns whether a module or program is replaced. `absent` tells that it is not there.
    pub(crate) fn replaces(&self, name: &str, absent: bool) -> bool {
        if self.names.contains(name) || self.all && absent {
            return true;
        }
        let known = known::find(name).map(|known| known.kind);
        match known {
            Some(PartKind::Program) => self.simulated,
            Some(PartKind::Module) => false,
            Some(PartKind::Screen) => self.headless,
            None => self.headless && known::is_view(name),
        }
    }

    /// Returns whether hardware is simulated.
    pub(super) const fn is_simulated(&self) -> bool {
        self.simulated
    }

    /// Returns whether no screen is shown.
    pub(crate) const fn is_headless(&self) -> bool {
        self.headless
    }
}
