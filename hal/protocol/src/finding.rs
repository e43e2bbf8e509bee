//! Findings of `check`.

use crate::{At, Code, Kind};
use serde::{Deserialize, Serialize};

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Worth knowing: loops, thread crossings, unconnected ends.
    Note,
    /// Very likely wrong.
    Warning,
    /// Cannot work.
    Error,
}

impl Level {
    /// Returns the name that users see.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// A fact about a machine that its user should know.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// Kind of the finding.
    pub code: Code,
    /// Severity.
    pub level: Level,
    /// Subject: the name of a pin, signal, function, thread or component, or a word of a script.
    pub subject: String,
    /// Script line that made the subject, if a script made it.
    pub at: Option<At>,
    /// The finding, as a sentence.
    pub text: String,
    /// Suggested correction. Empty if `text` already says it.
    pub remedy: String,
    /// Other script lines that are involved.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub related: Vec<Related>,
    /// Kind of things among which the subject was not found, or of which there are too many.
    #[serde(skip)]
    pub kind: Option<Kind>,
}

/// Another script line that a finding involves.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Related {
    /// Position of the line.
    pub at: At,
    /// Role of the line in the finding.
    pub text: String,
}

impl Finding {
    /// Returns a finding at the level of its code, without a position.
    #[must_use]
    pub fn new(code: Code, subject: &str, text: String) -> Self {
        Self {
            code,
            level: code.level(),
            subject: subject.to_owned(),
            at: None,
            text,
            remedy: String::new(),
            related: Vec::new(),
            kind: None,
        }
    }

    /// Sets the position.
    #[must_use]
    pub fn at(mut self, at: Option<At>) -> Self {
        self.at = at;
        self
    }

    /// Sets the suggested correction.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = remedy.into();
        self
    }

    /// Adds a related script line, if `at` names one.
    #[must_use]
    pub fn related(mut self, at: Option<At>, text: impl Into<String>) -> Self {
        self.related.extend(at.map(|at| Related { at, text: text.into() }));
        self
    }
}
