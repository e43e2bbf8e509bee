//! Errors of cutter-location files.

use std::fmt;

/// Problem, and where it is.
#[derive(Clone, PartialEq, Debug)]
pub struct Error {
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1.
    pub column: u32,
    /// Problem.
    pub problem: Problem,
}

/// Problem of a statement.
#[derive(Clone, PartialEq, Debug)]
pub enum Problem {
    /// The file is larger than [`MAX_BYTES`](super::MAX_BYTES).
    TooLarge,
    /// The part has more points than [`MAX_POINTS`](super::MAX_POINTS).
    TooManyPoints,
    /// A line is longer than a line can be.
    LongLine,
    /// A statement continues over too many lines.
    LongStatement,
    /// The file ends without `FINI`.
    NoEnd,
    /// The last line says that the statement goes on.
    Unfinished,
    /// A character that no statement has.
    Character(u8),
    /// A number is expected.
    Number(String),
    /// A number is too large to be a length.
    Range(String),
    /// A statement begins with no word.
    NoWord,
    /// Brackets do not match.
    Bracket,
    /// The numbers of a statement are not as many as it takes.
    Count(&'static str, &'static str),
    /// A unit that is not supported.
    Unit(String),
    /// A vector has no length.
    NoVector,
    /// Tool axes are switched off, and one is given.
    AxisOff,
    /// A feed is not above 0, or too slow.
    Feed,
    /// A feed per revolution without the revolutions.
    NoSpindle,
    /// A motion from the current position, and there is none.
    NoPosition,
    /// An arc whose start or end is not on its circle, and the distance.
    OffCircle(f64),
    /// An arc without `GOTO`.
    NoGoto,
    /// The direction of `INDIRV` is along no arc.
    NoDirection,
    /// A statement that would be needed and is not supported.
    Refused(String),
    /// A geometry name.
    Geometry(String),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge => write!(f, "the file is larger than {} bytes", super::MAX_BYTES),
            Self::TooManyPoints => {
                write!(f, "the part has more than {} points", super::MAX_POINTS)
            }
            Self::LongLine => f.write_str("the line is longer than 1000 characters"),
            Self::LongStatement => f.write_str("the statement is longer than 100 lines"),
            Self::NoEnd => f.write_str("the file ends without FINI: a part of it may be missing"),
            Self::Unfinished => f.write_str("the file ends within a statement that goes on"),
            Self::Character(byte) => write!(f, "no statement has the character {byte:#04x}"),
            Self::Number(text) => write!(f, "'{text}' is not a number"),
            Self::Range(text) => write!(f, "{text} is too large"),
            Self::NoWord => f.write_str("a statement begins with a word"),
            Self::Bracket => f.write_str("the brackets do not match"),
            Self::Count(word, takes) => write!(f, "{word} takes {takes}"),
            Self::Unit(text) => write!(f, "the unit '{text}' is not supported"),
            Self::NoVector => f.write_str("the vector has no length"),
            Self::AxisOff => f.write_str("a tool axis after MULTAX/OFF"),
            Self::Feed => f.write_str("a feed must be at least 0.001 mm a minute"),
            Self::NoSpindle => f.write_str("a feed per revolution needs SPINDL before it"),
            Self::NoPosition => f.write_str("there is no position to move from: FROM is missing"),
            Self::OffCircle(by) => write!(f, "an end of the arc is {by:.3} off its circle"),
            Self::NoGoto => f.write_str("GOTO must follow CIRCLE"),
            Self::NoDirection => f.write_str("INDIRV does not tell the direction of the arc"),
            Self::Refused(word) => write!(f, "{word} is not supported, and the path depends on it"),
            Self::Geometry(name) => write!(f, "geometry names are not supported: {name}"),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.problem)
    }
}

impl std::error::Error for Error {}
