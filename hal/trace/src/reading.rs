//! What a reader hands out: a trace, what it left out, and where it had to stop.

use crate::{Refusal, Trace};

/// Where in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Nowhere in particular.
    File,
    /// In a line, from 1.
    Line(u64),
    /// At a byte, from 0.
    Byte(u64),
}

/// Why a file is not read, or not further.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// It has no bytes.
    Empty,
    /// It is not of the kind that its reader reads.
    Foreign {
        /// The kind.
        wanted: &'static str,
    },
    /// It ends before it should.
    Truncated,
    /// It has fewer samples than it says.
    Short {
        /// How many it has.
        got: u64,
        /// How many it says.
        said: u64,
    },
    /// Something that cannot be read.
    Unreadable(Box<str>),
    /// A value of a thing that was not declared.
    Undeclared(Box<str>),
    /// A value that its channel cannot have.
    Value {
        /// The channel.
        channel: Box<str>,
        /// The value.
        value: Box<str>,
    },
    /// Times that do not increase, or too many samples.
    Refused(Refusal),
}

impl core::fmt::Display for Flaw {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Empty => write!(f, "the file is empty"),
            Self::Foreign { wanted } => write!(f, "this is no {wanted} file"),
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

/// What came of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// What was read; if there is a flaw, until there.
    pub trace: Trace,
    /// What the file has and a trace does not take, a sentence each.
    pub notes: Vec<String>,
    /// Where reading had to stop.
    pub flaw: Option<(Place, Flaw)>,
}

impl Reading {
    /// The trace, if all of the file was read.
    ///
    /// # Errors
    /// Where reading had to stop, and why.
    pub fn whole(self) -> Result<Trace, (Place, Flaw)> {
        match self.flaw {
            None => Ok(self.trace),
            Some(flaw) => Err(flaw),
        }
    }
}
