//! What `check` finds.

use crate::{At, Code};
use serde::{Deserialize, Serialize};

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Worth knowing: loops, thread crossings, loose ends.
    Note,
    /// Very likely wrong.
    Warning,
    /// Cannot work.
    Error,
}

impl Level {
    /// As users see it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// Something about a machine that its user ought to know.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// Which kind.
    pub code: Code,
    /// How bad it is.
    pub level: Level,
    /// What it is about: the name of a pin, signal, function, thread or component, or a word.
    pub subject: String,
    /// Where it stands, if a script made it.
    pub at: Option<At>,
    /// What is so, as a sentence.
    pub text: String,
    /// What to do; empty: the sentence says it.
    pub remedy: String,
    /// What else has to do with it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub related: Vec<Related>,
}

/// Another place that a finding has to do with.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Related {
    /// Where it stands.
    pub at: At,
    /// What is there.
    pub text: String,
}

impl Finding {
    /// A finding at its code's level, with no place yet.
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
        }
    }

    /// The same at a place.
    #[must_use]
    pub fn at(mut self, at: Option<At>) -> Self {
        self.at = at;
        self
    }

    /// The same with what to do.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = remedy.into();
        self
    }

    /// The same with another place.
    #[must_use]
    pub fn related(mut self, at: Option<At>, text: impl Into<String>) -> Self {
        self.related.extend(at.map(|at| Related { at, text: text.into() }));
        self
    }
}
