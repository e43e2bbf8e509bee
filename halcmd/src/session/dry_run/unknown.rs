//! Names that a dry run cannot know: pins of programs that it does not start.

use hal_protocol::{At, Code, Finding};
use std::collections::{BTreeMap, BTreeSet};

/// Names that may exist on the machine but do not exist in a dry run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unknown {
    prefixes: BTreeMap<String, Source>,
    used: BTreeMap<Source, Uses>,
    /// Tcl files of which a part is not known, which may make any name.
    unfollowed: BTreeSet<String>,
    /// Signals with unknown ends, including signals that do not exist in a dry run.
    pub signals: BTreeSet<String>,
}

/// Origin of names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Source {
    at: At,
    maker: Maker,
}

/// Program that makes names, or module that would have made them.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Maker {
    Program(String),
    /// Program that shows the machine.
    Screen(String),
    /// Module whose line was refused, which has been reported already.
    Module(String),
}

impl Maker {
    /// Returns the name of the program or module.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Program(name) | Self::Screen(name) | Self::Module(name) => name,
        }
    }
}

/// Uses of the names of one source.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Uses {
    names: BTreeSet<String>,
    lines: BTreeSet<At>,
}

/// Beginnings of the names that `motmod` makes.
pub const MOTION: &[&str] = &[
    "motion",
    "joint",
    "axis",
    "spindle",
    "motion-controller",
    "motion-command-handler",
    "servo-thread",
    "base-thread",
];

impl Unknown {
    /// Records that a program may make names that begin with this word.
    pub(super) fn expect(&mut self, word: &str, at: &At, maker: &Maker) {
        let usable = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '*');
        let is_name = word.starts_with(|c: char| c.is_ascii_alphanumeric())
            && word.contains(|c: char| c.is_ascii_alphabetic());
        if is_name && word.chars().all(usable) {
            let source = Source { at: at.clone(), maker: maker.clone() };
            self.prefixes.entry(word.to_owned()).or_insert(source);
        }
    }

    /// Records that a file may make any name. Returns false if it is recorded already.
    pub(super) fn begin_anything(&mut self, file: &str) -> bool {
        self.unfollowed.insert(file.to_owned())
    }

    /// Returns whether a file may have made any name.
    pub(crate) fn is_anything(&self) -> bool {
        !self.unfollowed.is_empty()
    }

    /// Returns whether a pin, parameter, function or component of this name may exist on the
    /// machine. The line at `at` uses it.
    pub(super) fn covers(&mut self, name: &str, at: &At) -> bool {
        let mut cuts = name.match_indices('.').map(|(at, _)| at).chain([name.len()]);
        let source = cuts.find_map(|at| self.prefixes.get(name.get(..at)?));
        let Some(source) = source.or_else(|| self.family(name)) else {
            return self.is_anything();
        };
        let uses = self.used.entry(source.clone()).or_default();
        uses.names.insert(name.to_owned());
        uses.lines.insert(at.clone());
        true
    }

    /// Returns the source whose names begin as this one does.
    fn family(&self, name: &str) -> Option<&Source> {
        let known = self
            .prefixes
            .iter()
            .filter_map(|(prefix, source)| prefix.strip_suffix('*').map(|prefix| (prefix, source)));
        known.filter(|(prefix, _)| name.starts_with(prefix)).map(|(_, source)| source).next()
    }

    /// Returns the program or module that may have made a name.
    pub(super) fn maker(&self, name: &str) -> Option<&Maker> {
        let mut cuts = name.match_indices('.').map(|(at, _)| at).chain([name.len()]);
        let source = cuts.find_map(|at| self.prefixes.get(name.get(..at)?));
        source.or_else(|| self.family(name)).map(|source| &source.maker)
    }

    /// Returns each program and module that may make names.
    pub(super) fn makers(&self) -> impl Iterator<Item = &Maker> {
        self.prefixes.values().map(|source| &source.maker)
    }

    /// Returns the programs and modules whose names are used.
    pub(super) fn users(&self) -> impl Iterator<Item = &str> {
        self.used.keys().map(|source| source.maker.name())
    }

    /// Returns a note for each program whose names are used.
    pub fn notes(&self) -> impl Iterator<Item = Finding> {
        self.used.iter().filter_map(|(source, Uses { names, .. })| {
            let (Maker::Program(program) | Maker::Screen(program)) = &source.maker else {
                return None;
            };
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

    /// Returns each refused line that loads a module, with the name of the module and the number of lines that need it.
    pub fn missed(&self) -> impl Iterator<Item = (&At, &str, usize)> {
        self.used.iter().filter_map(|(source, uses)| match &source.maker {
            Maker::Module(name) => Some((&source.at, name.as_str(), uses.lines.len())),
            Maker::Program(_) | Maker::Screen(_) => None,
        })
    }
}
