//! Statements of a file: lines joined, comments and labels removed, with the place of each character.

use super::{Error, MAX_BYTES, Problem};

/// Longest line, in bytes.
const MAX_LINE: usize = 1000;
/// Largest number of lines of a statement.
const MAX_LINES: usize = 100;
/// First column of a label, from 0.
const LABEL: usize = 72;

/// Character of a statement with its place.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Char {
    pub(super) byte: u8,
    pub(super) line: u32,
    pub(super) column: u32,
}

/// Statement: its characters without blanks, or all of them if it is text.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Statement {
    pub(super) chars: Vec<Char>,
    pub(super) is_text: bool,
}

/// Statements that are text from their first word on.
const TEXTS: [&str; 4] = ["PARTNO", "PPRINT", "TPRINT", "INSERT"];

/// Returns an error at a place.
fn error(line: u32, column: u32, problem: Problem) -> Error {
    Error { line, column, problem }
}

/// Splits a file into statements and gives them to `take`, which returns false after the last.
pub(super) fn statements(
    text: &[u8],
    mut take: impl FnMut(&Statement) -> Result<bool, Error>,
) -> Result<(), Error> {
    if text.len() > MAX_BYTES {
        return Err(error(1, 1, Problem::TooLarge));
    }
    let text = text.strip_suffix(b"\n").unwrap_or(text);
    let mut statement: Option<(Statement, usize)> = None;
    let mut last = (1, 1);
    for (number, line) in (1_u32..).zip(text.split(|b| *b == b'\n')) {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        last = (number, 1);
        if line.len() > MAX_LINE {
            return Err(error(number, u32::try_from(MAX_LINE).unwrap_or(0), Problem::LongLine));
        }
        let is_text = statement.is_none() && begins_text(line);
        let line = if is_text { line } else { without_label(line) };
        let (line, goes_on) = if is_text { (line, false) } else { without_comment(line) };
        let (mut whole, lines) =
            statement.take().unwrap_or((Statement { chars: Vec::new(), is_text }, 0));
        if lines >= MAX_LINES {
            return Err(error(number, 1, Problem::LongStatement));
        }
        for (column, byte) in (1_u32..).zip(line) {
            let is_blank = *byte == b' ' || *byte == b'\t';
            if !is_text && !is_blank && !byte.is_ascii_graphic() {
                return Err(error(number, column, Problem::Character(*byte)));
            }
            if is_text || !is_blank {
                let byte = if is_text { *byte } else { byte.to_ascii_uppercase() };
                whole.chars.push(Char { byte, line: number, column });
            }
        }
        if goes_on {
            statement = Some((whole, lines + 1));
        } else if !whole.chars.iter().all(|c| c.byte.is_ascii_whitespace()) && !take(&whole)? {
            return Ok(());
        }
    }
    let problem = if statement.is_some() { Problem::Unfinished } else { Problem::NoEnd };
    Err(error(last.0, last.1, problem))
}

fn begins_text(line: &[u8]) -> bool {
    let from = line.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(line.len());
    let line = line.get(from..).unwrap_or_default();
    TEXTS.iter().any(|t| line.get(..t.len()).is_some_and(|w| w.eq_ignore_ascii_case(t.as_bytes())))
}

/// Removes the label from column 73 on: letters and then digits, after a blank.
fn without_label(line: &[u8]) -> &[u8] {
    let Some((before, label)) = line.split_at_checked(LABEL) else { return line };
    let text: Vec<u8> = label.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
    let digits = text.iter().rev().take_while(|b| b.is_ascii_digit()).count();
    let letters = text.iter().take_while(|b| b.is_ascii_alphabetic()).count();
    let is_label = digits > 0 && letters > 0 && digits + letters == text.len();
    let is_apart = before.last().is_none_or(|b| b.is_ascii_whitespace() || *b == b'$');
    if is_label && is_apart { before } else { line }
}

/// Removes a comment, and a `$` at the end; returns whether the statement goes on.
fn without_comment(line: &[u8]) -> (&[u8], bool) {
    let comment = line.windows(2).position(|pair| pair == b"$$");
    let line = line.get(..comment.unwrap_or(line.len())).unwrap_or_default().trim_ascii_end();
    line.strip_suffix(b"$").map_or((line, false), |line| (line, true))
}

/// Returns an error at a character.
pub(super) fn at(place: &Char, problem: Problem) -> Error {
    error(place.line, place.column, problem)
}

/// Returns the characters as text, shortened.
pub(super) fn shown(chars: &[Char]) -> String {
    chars.iter().take(40).map(|c| char::from(c.byte)).collect()
}
