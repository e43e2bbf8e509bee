//! What a trial cannot know: the pins of programs that it does not start.

use hal_protocol::At;
use std::collections::{BTreeMap, BTreeSet};

/// Names that may exist on the machine and do not exist on trial.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unknown {
    /// Names begin with one of these and a dot; where it comes from.
    pub prefixes: BTreeMap<String, At>,
    /// Signals with ends that are not known, whether they exist on trial or not.
    pub signals: BTreeSet<String>,
}

impl Unknown {
    /// A program may make names that begin with this word.
    pub fn expect(&mut self, word: &str, at: &At) {
        let usable = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        if word.starts_with(|c: char| c.is_ascii_alphabetic()) && word.chars().all(usable) {
            self.prefixes.entry(word.to_owned()).or_insert_with(|| at.clone());
        }
    }

    /// Whether a pin, parameter, function or component of this name may exist on the machine.
    #[must_use]
    pub fn covers(&self, name: &str) -> bool {
        let mut cuts = name.match_indices('.').map(|(at, _)| at).chain([name.len()]);
        cuts.any(|at| name.get(..at).is_some_and(|p| self.prefixes.contains_key(p)))
    }
}
