//! Result of reading a file: the trace, the parts left out, and the flaw that stopped the reading.

use crate::{Refusal, Trace};

/// Position in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Position {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(u64),
    /// A byte offset, from 0.
    Byte(u64),
}

/// Reason why a file is not read, or not read to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// The file is empty.
    Empty,
    /// The file does not have the format of the reader.
    Foreign {
        /// Name of the expected format.
        wanted: &'static str,
    },
    /// The file ends too early.
    Truncated,
    /// The file has fewer samples than it declares.
    Short {
        /// Number of samples found.
        got: u64,
        /// Number of samples declared.
        said: u64,
    },
    /// Invalid syntax, described by this text.
    Unreadable(Box<str>),
    /// A value for a variable that was not declared.
    Undeclared(Box<str>),
    /// A value that is invalid for its channel.
    Value {
        /// Name of the channel.
        channel: Box<str>,
        /// Text of the value.
        value: Box<str>,
    },
    /// Times do not increase, or there are too many samples.
    Refused(Refusal),
}

impl core::fmt::Display for Flaw {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Empty => write!(f, "the file is empty"),
            Self::Foreign { wanted } => write!(f, "this is not a {wanted} file"),
            Self::Truncated => write!(f, "the file ends too early"),
            Self::Short { got, said } => {
                write!(f, "the file ends too early: {got} samples of {said}")
            }
            Self::Unreadable(what) => write!(f, "{what}"),
            Self::Undeclared(what) => write!(f, "a value for '{what}', which is not declared"),
            Self::Value { channel, value } => write!(f, "'{channel}' cannot be '{value}'"),
            Self::Refused(refusal) => write!(f, "{refusal}"),
        }
    }
}

impl core::error::Error for Flaw {}

/// Result of reading a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// The samples that were read. If there is a flaw, those before it.
    pub trace: Trace,
    /// Contents of the file that the trace cannot hold, one sentence each.
    pub notes: Vec<String>,
    /// Place and kind of the flaw that stopped the reading.
    pub flaw: Option<(Position, Flaw)>,
}

impl Reading {
    /// Returns the trace if the whole file was read.
    ///
    /// # Errors
    /// The place and kind of the flaw.
    pub fn whole(self) -> Result<Trace, (Position, Flaw)> {
        match self.flaw {
            None => Ok(self.trace),
            Some(flaw) => Err(flaw),
        }
    }
}
