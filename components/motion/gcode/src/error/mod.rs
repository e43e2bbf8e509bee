//! Errors: the place of a problem, the problem, and its remedy.

mod problem;

use core::fmt;

use serde::{Deserialize, Serialize};

pub use problem::Problem;

/// The place of a problem.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// The file.
    pub file: Box<str>,
    /// The line, from 1; 0 before the first.
    pub line: u32,
    /// The column, from 1; 0 for the whole line.
    pub column: u32,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)?;
        if self.column > 0 { write!(f, ":{}", self.column) } else { Ok(()) }
    }
}

/// A problem at its place, with the calls that led there.
#[derive(Clone, Debug, PartialEq)]
pub struct Error {
    /// The place.
    pub place: Place,
    /// The problem.
    pub problem: Problem,
    /// The places of the calls in progress, the outermost first.
    pub calls: Vec<Place>,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.problem)?;
        let remedy = self.problem.remedy();
        if !remedy.is_empty() {
            write!(f, " ({remedy})")?;
        }
        for call in self.calls.iter().rev() {
            write!(f, "\n  called from {call}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}
