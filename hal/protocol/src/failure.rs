//! Reason why a request failed.

use crate::{Code, Kind};
use serde::{Deserialize, Serialize};

/// Reason why a request failed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// A negative errno.
    pub code: i32,
    /// Error message. It uses LinuxCNC's wording where LinuxCNC has the same message.
    pub text: String,
    /// Suggested correction: a similar name, the expected type, the permitted range.
    pub hint: Option<String>,
    /// Wrong word of the request, if a single word is wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub word: Option<String>,
    /// Finding about which `explain` says more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finding: Option<Code>,
    /// Kind of things among which a name was not found, or of which there are too many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<Kind>,
}

impl Failure {
    /// Returns a failure without a hint.
    #[must_use]
    pub fn new(code: i32, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { code, text, hint: None, word: None, finding: None, kind: None }
    }
}

impl core::fmt::Display for Failure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.text)?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(f, "; {hint}"))
    }
}

impl std::error::Error for Failure {}
