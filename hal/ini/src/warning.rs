//! Warnings about lines that are legal.

use core::fmt;

/// Warning about a line that is legal but doubtful.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IniWarning {
    /// File that contains the line, as messages name it.
    pub file: String,
    /// Line number, from 1.
    pub line: u32,
    /// Kind of the doubt.
    pub doubt: Doubt,
    /// The warning, as a sentence.
    pub text: String,
}

/// Kind of a doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// The line, or a part of it, has no effect.
    Ignored,
    /// The file has begun this section before.
    Repeated,
}

impl fmt::Display for IniWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: Warning: {}", self.file, self.line, self.text)
    }
}
