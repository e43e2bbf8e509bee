//! Position in a script at which a request was made.

use serde::{Deserialize, Serialize};

/// A line of a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct At {
    /// File name, as messages print it.
    pub file: String,
    /// Line number, from 1. Zero means the file as a whole.
    pub line: u32,
}

impl At {
    /// Returns the position of a line in a file.
    #[must_use]
    pub fn new(file: &str, line: u32) -> Self {
        Self { file: file.to_owned(), line }
    }

    /// Sets `place` to this line. Allocates a new file name only when the file has changed.
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
