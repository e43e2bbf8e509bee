//! Reasons why `haltest` ends without results.

use std::path::Path;

/// Reason why no test could run or no result could be reported.
#[derive(Debug)]
pub(super) enum Failure {
    /// The command line is invalid.
    Asked(String),
    /// The results could not be written.
    Unwritten(String),
}

impl From<hal_output::Unwritten> for Failure {
    fn from(unwritten: hal_output::Unwritten) -> Self {
        Self::Unwritten(unwritten.to_string())
    }
}

impl Failure {
    /// Error for a file that could not be written.
    pub(super) fn file(path: &Path, error: &std::io::Error) -> Self {
        Self::Unwritten(format!("{}: {}", path.display(), hal_output::reason(error)))
    }
}
