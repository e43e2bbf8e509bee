//! What is wrong with a line, and where.

use crate::{Error, lex::is_arrow};
use hal_protocol::Failure;

/// Bytes of a line, from and to.
pub type Span = core::ops::Range<usize>;

/// Why a line was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What is wrong.
    pub error: Box<Error>,
    /// Where: bytes of the line as it was joined; absent when no part of it is to blame.
    pub at: Option<Span>,
    /// What is said after it.
    pub after: Vec<String>,
    /// Whether that is enough for those who want to hear little (`-Q`).
    pub(crate) quiet: bool,
}

impl Fault {
    pub(crate) fn at(error: Error, at: Span) -> Self {
        Self { error: Box::new(error), at: Some(at), after: Vec::new(), quiet: false }
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self { error: Box::new(error), at: None, after: Vec::new(), quiet: false }
    }
}

/// Which words of a command an error is about; those after the last one when one is missing.
pub(crate) fn blamed(error: &Error, words: &[String]) -> Span {
    let count = words.len();
    let one = |n: usize| n..n + 1;
    match error {
        Error::UnknownCommand { .. } | Error::NotApplied { .. } => one(0),
        Error::Exactly { wanted, given, .. } if given > wanted => surplus(words, *wanted)..count,
        Error::AtMost { wanted, .. } => surplus(words, *wanted)..count,
        Error::Exactly { .. }
        | Error::AtLeast { .. }
        | Error::NoPin
        | Error::NoFunct
        | Error::NoThread
        | Error::NoProgram
        | Error::NeedsArgument { .. } => one(count),
        Error::SignalType { word }
        | Error::FilterType { word }
        | Error::AliasKind { word, .. }
        | Error::Switch { word }
        | Error::Kind { word, .. }
        | Error::NoHelp { word, .. }
        | Error::Time { word }
        | Error::NotLoaded { name: word, .. }
        | Error::NotAProgram { name: word }
        | Error::NotStarted { program: word, .. }
        | Error::ProgramFailed { program: word, .. }
        | Error::ProgramKilled { program: word }
        | Error::NotReady { program: word, .. } => find(words, word).map_or(0..count, one),
        Error::Level | Error::NoFile { .. } => one(1),
        Error::NoDestination { .. } | Error::NotWritten { .. } => one(2),
        Error::BadOption { option, .. } => {
            let given = |w: &String| w.starts_with('-') && w.contains(*option);
            words.iter().position(given).map_or(0..count, one)
        }
        Error::Engine(failure) => refused(failure, words),
        _ => 0..count,
    }
}

/// The word that the engine refused, if it names one; else the value that was to be set.
fn refused(failure: &Failure, words: &[String]) -> Span {
    let named = failure.word.as_deref().and_then(|word| find(words, word));
    match (named, words) {
        (Some(n), _) => n..n + 1,
        (None, [command, middle, _])
            if matches!(command.as_str(), "setp" | "sets") || middle == "=" =>
        {
            2..3
        }
        (None, [command, _, _, _]) if matches!(command.as_str(), "addf" | "initf") => 3..4,
        _ => 0..words.len(),
    }
}

/// The word of this text, or that gives an argument of this name.
fn find(words: &[String], text: &str) -> Option<usize> {
    let position =
        |fits: &dyn Fn(&str) -> bool| words.iter().skip(1).position(|w| fits(w)).map(|n| n + 1);
    position(&|w| w == text)
        .or_else(|| position(&|w| w.trim_matches('"') == text))
        .or_else(|| position(&|w| w.strip_prefix(text).is_some_and(|rest| rest.starts_with('='))))
        .or_else(|| words.first().filter(|w| *w == text).map(|_| 0))
}

/// The first word that is too many; arrows do not count where they mean nothing.
fn surplus(words: &[String], wanted: usize) -> usize {
    let joins = words.first().is_some_and(|w| matches!(w.as_str(), "linkps" | "linksp"));
    let counted = |(_, w): &(usize, &String)| !(joins && is_arrow(w));
    let mut rest = words.iter().enumerate().skip(1).filter(counted);
    rest.nth(wanted).map_or(words.len(), |(n, _)| n)
}
