//! Refusals of a start in the middle of a program.

use crate::dry_run::{LineBegin, Series, Unknown};
use core::fmt;
use hal_gcode::{Error, error::Place};

/// Reason for which a program cannot begin at a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// The line is not reached that often.
    NotReached {
        /// The file.
        file: Box<str>,
        /// The line.
        line: u32,
        /// Number of times that it is reached.
        times: u32,
    },
    /// The state depends on a fact that only the machine knew.
    Unknown {
        /// The line that asks for the fact.
        place: Place,
        /// The fact.
        what: Unknown,
    },
    /// The line is in the middle of lines that belong together.
    Middle {
        /// The line.
        place: Place,
        /// The lines.
        of: Series,
        /// The last line before it from which a start is possible.
        from: Option<LineBegin>,
        /// The next line behind it from which a start is possible.
        next: Option<LineBegin>,
    },
    /// The program has an error before the line.
    Program(Box<Error>),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotReached { file, line, times: 0 } => {
                write!(f, "{file}:{line}: the program does not reach this line")
            }
            Self::NotReached { file, line, times } => {
                write!(f, "{file}:{line}: the program reaches this line {times} times only")
            }
            Self::Unknown { place, what } => write!(
                f,
                "{place}: {what} is not known without the machine: a start behind this line is not possible"
            ),
            Self::Middle { place, of, from, next } => {
                write!(f, "{place}: a start in the middle of {of} is not possible")?;
                match (from, next) {
                    (Some(from), Some(next)) => write!(f, "; from {from} or from {next} it is"),
                    (Some(begin), None) | (None, Some(begin)) => write!(f, "; from {begin} it is"),
                    (None, None) => Ok(()),
                }
            }
            Self::Program(error) => write!(f, "{error}"),
        }
    }
}

impl fmt::Display for LineBegin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}
