//! Refusals of INI files.

use core::fmt;

/// Reason for which an INI file was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The file cannot be read.
    File {
        /// Path as it was given.
        path: Box<str>,
        /// Reason that the system gave.
        why: Box<str>,
    },
    /// A line is malformed, or a file that it includes cannot be read.
    Syntax {
        /// File that holds the line.
        path: Box<str>,
        /// Line, from 1.
        line: u32,
        /// Cause and remedy.
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
