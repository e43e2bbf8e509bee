//! Dialects: the languages in which a program can be written.

use serde::{Deserialize, Serialize};

/// The language of programs. Lines of MDI are always in LinuxCNC's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Dialect {
    /// LinuxCNC's RS274/NGC.
    #[default]
    LinuxCnc,
    /// RS274-D, as small mills of the nineties have it: lines, arcs in XY, dwells, no variables.
    Rs274d,
}

impl Dialect {
    /// All dialects with their names, as options and INI files write them.
    pub const ALL: [(&'static str, Self); 2] =
        [("linuxcnc", Self::LinuxCnc), ("rs274d", Self::Rs274d)];
    /// The names, as an error lists them.
    pub const NAMES: &'static str = "linuxcnc or rs274d";

    /// Returns the dialect of a name; upper and lower case are the same.
    pub fn named(name: &str) -> Option<Self> {
        let found = Self::ALL.iter().find(|(n, _)| n.eq_ignore_ascii_case(name.trim()));
        found.map(|(_, dialect)| *dialect)
    }
}
