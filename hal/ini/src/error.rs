//! Errors of INI files.

use core::fmt;

/// Reason why an INI file was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The file cannot be read.
    File {
        /// Path, as the caller gave it.
        path: Box<str>,
        /// Reason from the system.
        why: Box<str>,
    },
    /// A line is malformed, or a file that it includes cannot be read.
    Syntax {
        /// File that contains the line.
        path: Box<str>,
        /// Line number, from 1.
        line: u32,
        /// Cause and suggested correction.
        why: Box<str>,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { path, .. } => write!(f, "Could not open INI file '{path}'"),
            Self::Syntax { path, line, why } => write!(f, "{path}:{line}: {why}"),
        }
    }
}

impl core::error::Error for Error {}
