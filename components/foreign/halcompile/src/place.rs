//! Places in a file, and reports of faults as people read them.

use crate::Problem;
use core::fmt;

/// Range of a file, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// Byte after the last one.
    pub end: usize,
}

/// Fault with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Place of the fault.
    pub span: Span,
    /// Kind of the fault.
    pub problem: Problem,
}

/// All faults or warnings of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    file: String,
    text: String,
    faults: Vec<Fault>,
}

impl Report {
    /// Makes a report for a file with this text.
    #[must_use]
    pub fn new(file: &str, text: &str, faults: Vec<Fault>) -> Self {
        Self { file: file.to_owned(), text: text.to_owned(), faults }
    }

    /// Returns the faults.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for fault in &self.faults {
            let (number, column, line) = place(&self.text, fault.span.start);
            let shown: String = line.chars().map(|c| if c == '\t' { ' ' } else { c }).collect();
            let rest = line.chars().count().saturating_sub(column - 1);
            let long = self.text.get(fault.span.start..fault.span.end).unwrap_or_default();
            let long = long.chars().take_while(|c| *c != '\n').count();
            let marks = "^".repeat(long.min(rest).max(1));
            writeln!(f, "{}:{number}:{column}: {}", self.file, fault.problem)?;
            writeln!(f, "    {shown}")?;
            writeln!(f, "    {}{marks}", " ".repeat(column - 1))?;
        }
        Ok(())
    }
}

impl core::error::Error for Report {}

/// Returns line and column of a byte, both from 1, and the text of the line.
pub(crate) fn place(text: &str, at: usize) -> (usize, usize, &str) {
    let at = (0..=at.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
    let (before, after) = text.split_at_checked(at).unwrap_or((text, ""));
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    let end = after.find('\n').map_or(text.len(), |i| at + i);
    let line = text.get(start..end).unwrap_or_default();
    let column = before.get(start..).unwrap_or_default().chars().count() + 1;
    (before.matches('\n').count() + 1, column, line.trim_end_matches('\r'))
}
