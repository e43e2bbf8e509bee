//! A row of the table, and the functions that make one.

use super::Control;

/// Mark of another control in a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// A code.
    Code(u8, u32),
    /// Each of the codes from the first to the last; too common to tell the control.
    Codes(u8, u32, u32),
    /// A code on one line with this word.
    With(u8, u32, u8),
    /// A code on one line with a P that is a whole number without a decimal point.
    WholeP(u8, u32),
    /// A line that begins with this text.
    Begins(&'static str),
    /// A line that is this text.
    Is(&'static str),
    /// A line with this text in it.
    Has(&'static str),
    /// A line that begins with this letter, digits and an equal sign.
    Assigns(u8),
    /// A line of the letter O and so many digits at least, and so many at most.
    Program(usize, usize),
    /// A tool's word with four digits.
    FourDigitTool,
    /// A comment in the first lines with this text, in lower case.
    Remark(&'static str),
}

/// Evidence of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// This language does not understand it: it tells the control.
    Strange,
    /// This language understands it: it tells the control beside a strange sign.
    Habit,
    /// This language gives it another meaning: it is named once the control is known.
    Other,
    /// A mark that tells the control, and asks for no change.
    Name,
}

/// A code or word of other controls.
#[derive(Debug, PartialEq, Eq)]
pub struct CodeRow {
    /// Mark in a program.
    pub sign: Sign,
    /// The name of a text; a code has its own.
    pub shown: &'static str,
    /// The controls that have it.
    pub of: &'static [Control],
    /// Evidence that it gives.
    pub weight: Weight,
    /// Meaning at that control.
    pub means: &'static str,
    /// Text to write instead.
    pub instead: &'static str,
}

/// Returns the row of a code that this language does not have.
pub(super) const fn code(
    of: &'static [Control],
    letter: u8,
    tenfold: u32,
    means: &'static str,
    instead: &'static str,
) -> CodeRow {
    row(Sign::Code(letter, tenfold), "", of, Weight::Strange, means, instead)
}

/// Returns the row of a text that this language does not have.
pub(super) const fn text(
    of: &'static [Control],
    sign: Sign,
    shown: &'static str,
    means: &'static str,
    instead: &'static str,
) -> CodeRow {
    row(sign, shown, of, Weight::Strange, means, instead)
}

/// Returns the row of something that this language understands as something else.
pub(super) const fn other(
    of: &'static [Control],
    sign: Sign,
    means: &'static str,
    instead: &'static str,
) -> CodeRow {
    row(sign, "", of, Weight::Other, means, instead)
}

/// Returns the row of a comment that names a control.
pub(super) const fn remark(of: &'static [Control], text: &'static str) -> CodeRow {
    row(Sign::Remark(text), text, of, Weight::Name, "", "")
}

pub(super) const fn row(
    sign: Sign,
    shown: &'static str,
    of: &'static [Control],
    weight: Weight,
    means: &'static str,
    instead: &'static str,
) -> CodeRow {
    CodeRow { sign, shown, of, weight, means, instead }
}
