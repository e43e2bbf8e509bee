//! Faults: the error of a line and its position.

use crate::{Error, language::lex::is_arrow};
use hal_protocol::Failure;

/// Byte range in a line.
pub type Span = core::ops::Range<usize>;

/// Error of a refused line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The error.
    pub error: Box<Error>,
    /// Bytes of the joined line to which the error refers; `None` if it refers to no part of it.
    pub at: Option<Span>,
    /// Messages that follow.
    pub after: Vec<String>,
    /// True if `-Q` omits the error and prints only those messages.
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

/// Returns the range of words to which an error refers. For a missing word it is after the last
/// word.
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

/// Returns the word that the engine refused, or else the value that was to be set.
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

/// Finds the word with this text, or the one that sets an argument of this name.
fn find(words: &[String], text: &str) -> Option<usize> {
    let position =
        |fits: &dyn Fn(&str) -> bool| words.iter().skip(1).position(|w| fits(w)).map(|n| n + 1);
    position(&|w| w == text)
        .or_else(|| position(&|w| w.trim_matches('"') == text))
        .or_else(|| position(&|w| w.strip_prefix(text).is_some_and(|rest| rest.starts_with('='))))
        .or_else(|| words.first().filter(|w| *w == text).map(|_| 0))
}

/// Returns the index of the first surplus word. Arrows are not counted in commands that ignore
/// them.
fn surplus(words: &[String], wanted: usize) -> usize {
    let joins = words.first().is_some_and(|w| matches!(w.as_str(), "linkps" | "linksp"));
    let counted = |(_, w): &(usize, &String)| !(joins && is_arrow(w));
    let mut rest = words.iter().enumerate().skip(1).filter(counted);
    rest.nth(wanted).map_or(words.len(), |(n, _)| n)
}
