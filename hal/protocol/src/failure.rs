//! Why a request was refused.

use crate::Code;
use serde::{Deserialize, Serialize};

/// Why a request was refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// A negative errno.
    pub code: i32,
    /// What is wrong, as LinuxCNC words it where it does.
    pub text: String,
    /// What would be right: a near name, the expected type, the legal range.
    pub hint: Option<String>,
    /// The word of the request that is wrong, if it is one word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub word: Option<String>,
    /// What led to it, one sentence each, printed before `text`.
    pub before: Vec<String>,
    /// What `explain` says more about.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finding: Option<Code>,
}

impl Failure {
    /// A failure without a hint.
    #[must_use]
    pub fn new(code: i32, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { code, text, hint: None, word: None, before: Vec::new(), finding: None }
    }
}

impl core::fmt::Display for Failure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.text)?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(f, "; {hint}"))
    }
}

impl std::error::Error for Failure {}
