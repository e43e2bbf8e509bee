//! Refusals of a start in the middle of a program.

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

/// A line on the way of a program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LineBegin {
    /// Number of lines that have run before it.
    pub number: u64,
    /// The file.
    pub file: Box<str>,
    /// The line, from 1.
    pub line: u32,
}

/// A fact that only the machine knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// The effect of a function in Python.
    Function,
    /// The value of a HAL item.
    Hal,
    /// The result of M66.
    Input,
    /// The result of a probe.
    Probe,
}

/// Lines that belong together: a start between them is not possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Series {
    /// Cutter compensation.
    Compensation,
    /// A chain of canned cycles.
    Cycle,
    /// A function in Python and the lines that it executes.
    Function,
    /// The control points of a NURBS.
    Nurbs,
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Function => "the effect of a function in Python",
            Self::Hal => "a value of HAL",
            Self::Input => "the result of M66",
            Self::Probe => "the result of a probe",
        })
    }
}

impl fmt::Display for Series {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Compensation => "cutter compensation",
            Self::Cycle => "a series of canned cycles",
            Self::Function => "a function in Python",
            Self::Nurbs => "a NURBS",
        })
    }
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
                    (Some(from), Some(next)) => write!(f, "; start at {from} or {next} instead"),
                    (Some(begin), None) | (None, Some(begin)) => {
                        write!(f, "; start at {begin} instead")
                    }
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
