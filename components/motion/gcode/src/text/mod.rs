//! A line of G-code: from bytes to words, expressions, comments and O-words, each with its column.

pub mod clean;
pub mod comment;
pub mod evaluate;
pub mod expression;
pub mod line;
pub mod number;
pub mod oword;
pub mod rs274d;

use crate::error::Problem;

/// The rest of a cleaned line that a parser has not read yet.
pub type Input<'a> = &'a [u8];

/// A problem and the rest of the line where it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault<'a> {
    /// The rest of the line.
    pub at: Input<'a>,
    /// The problem.
    pub problem: Problem,
}

impl<'a> nom::error::ParseError<Input<'a>> for Fault<'a> {
    fn from_error_kind(at: Input<'a>, _: nom::error::ErrorKind) -> Self {
        Self { at, problem: Problem::of_byte(at.first().copied()) }
    }

    fn append(_: Input<'a>, _: nom::error::ErrorKind, other: Self) -> Self {
        other
    }
}

/// The result of a parser of this crate.
pub type Parsed<'a, T> = nom::IResult<Input<'a>, T, Fault<'a>>;

/// Fails at `at` with `problem`; no alternative is tried.
pub(crate) fn fail<T>(at: Input<'_>, problem: Problem) -> Parsed<'_, T> {
    Err(nom::Err::Failure(Fault { at, problem }))
}
