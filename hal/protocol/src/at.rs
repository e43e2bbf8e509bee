//! Where in a script something was asked for.

use serde::{Deserialize, Serialize};

/// A line of a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct At {
    /// The file, as messages call it.
    pub file: String,
    /// Its line, from 1; zero: the file as a whole.
    pub line: u32,
}

impl At {
    /// A line of a file.
    #[must_use]
    pub fn new(file: &str, line: u32) -> Self {
        Self { file: file.to_owned(), line }
    }

    /// Makes this the place, without a new text while the file is the same.
    pub fn keep(place: &mut Option<Self>, file: &str, line: u32) {
        match place {
            Some(at) if at.file == file => at.line = line,
            _ => *place = Some(Self::new(file, line)),
        }
    }
}

impl core::fmt::Display for At {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.line {
            0 => f.write_str(&self.file),
            line => write!(f, "{}:{line}", self.file),
        }
    }
}
