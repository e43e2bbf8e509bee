//! Names that a dry run cannot know: pins of programs that it does not start.

use hal_protocol::{At, Code, Finding};
use std::collections::{BTreeMap, BTreeSet};

/// Names that may exist on the machine but do not exist in a dry run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unknown {
    prefixes: BTreeMap<String, Source>,
    used: BTreeMap<Source, BTreeSet<String>>,
    /// Signals with unknown ends, including signals that do not exist in a dry run.
    pub signals: BTreeSet<String>,
}

/// Origin of names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Source {
    at: At,
    /// Name of the program; `None` for a component that could not be loaded, which has been
    /// reported already.
    program: Option<String>,
}

impl Unknown {
    /// Records that a program may make names that begin with this word.
    pub(super) fn expect(&mut self, word: &str, at: &At, program: Option<&str>) {
        let usable = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        let is_name = word.starts_with(|c: char| c.is_ascii_alphanumeric())
            && word.contains(|c: char| c.is_ascii_alphabetic());
        if is_name && word.chars().all(usable) {
            let source = Source { at: at.clone(), program: program.map(str::to_owned) };
            self.prefixes.entry(word.to_owned()).or_insert(source);
        }
    }

    /// Returns whether a pin, parameter, function or component of this name may exist on the
    /// machine.
    pub(super) fn covers(&mut self, name: &str) -> bool {
        let mut cuts = name.match_indices('.').map(|(at, _)| at).chain([name.len()]);
        let source = cuts.find_map(|at| self.prefixes.get(name.get(..at)?));
        let Some(source) = source else { return false };
        self.used.entry(source.clone()).or_default().insert(name.to_owned());
        true
    }

    /// Returns a note for each program whose names are used.
    pub fn notes(&self) -> impl Iterator<Item = Finding> {
        self.used.iter().filter_map(|(source, names)| {
            let program = source.program.as_ref()?;
            let first = names.first()?;
            let more = match names.len() {
                1 => String::new(),
                n => format!(" and {} more", n - 1),
            };
            let text =
                format!("the pins of '{program}' are not known here: '{first}'{more} may be right");
            Some(
                Finding::new(Code::ProgramPins, program, text)
                    .at(Some(source.at.clone()))
                    .remedy("check the running machine to have them looked at: halcmd check"),
            )
        })
    }
}
