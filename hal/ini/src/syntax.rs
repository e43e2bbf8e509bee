//! Syntax of a line: section headers, entries, escapes.

use nom::{
    IResult, Parser,
    bytes::complete::{take_while, take_while_m_n},
    character::complete::{anychar, char, satisfy, space0},
    combinator::{recognize, rest},
    sequence::{delimited, separated_pair, terminated},
};

/// Splits a text into lines and joins each continued line with the next. Returns each line with the
/// number of its last physical line, or with `None` if it is not UTF-8.
pub(crate) fn joined(text: &[u8]) -> Vec<(u32, Option<String>)> {
    let mut out = Vec::new();
    let mut pending: Vec<u8> = Vec::new();
    let mut number = 0;
    for line in text.split(|b| *b == b'\n') {
        number += 1;
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if let Some(start) = line.strip_suffix(b"\\") {
            pending.extend_from_slice(start);
        } else {
            pending.extend_from_slice(line);
            out.push((number, String::from_utf8(core::mem::take(&mut pending)).ok()));
        }
    }
    if !pending.is_empty() {
        out.push((number, String::from_utf8(pending).ok()));
    }
    out
}

/// Parses `[NAME]`. Returns the text after it, without the whitespace before that.
pub(crate) fn header(text: &str) -> IResult<&str, &str> {
    terminated(delimited((char('['), space0), identifier, (space0, char(']'))), space0).parse(text)
}

/// Parses `NAME = value`. The value is the rest of the line.
pub(crate) fn entry(text: &str) -> IResult<&str, (&str, &str)> {
    separated_pair(identifier, (space0, char('='), space0), rest).parse(text)
}

/// Parses a name of letters, digits and `_`. Older files also use `-` and `.` after the first
/// character.
fn identifier(text: &str) -> IResult<&str, &str> {
    recognize((
        satisfy(|c| c.is_ascii_alphabetic() || c == '_'),
        take_while(|c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.')),
    ))
    .parse(text)
}

/// Decodes `\t \x41 \101 \u00e9` and similar escapes. A backslash before any other character is
/// kept. Returns `None` if an escape is not a valid character.
pub(crate) fn decoded(value: &str) -> Option<String> {
    let mut out = String::new();
    let mut rest = value;
    while let Some((before, after)) = rest.split_once('\\') {
        out.push_str(before);
        let (left, c) = match escape(after) {
            Ok((left, code)) => (left, char::from_u32(code)?),
            Err(_) => (after, '\\'),
        };
        out.push(c);
        rest = left;
    }
    out.push_str(rest);
    Some(out)
}

fn escape(text: &str) -> IResult<&str, u32> {
    let (rest, c) = anychar(text)?;
    let simple = |code: u32| Ok((rest, code));
    match c {
        'a' => simple(7),
        'b' => simple(8),
        'f' => simple(12),
        'n' => simple(10),
        'r' => simple(13),
        't' => simple(9),
        'v' => simple(11),
        '\\' => simple(92),
        'x' => number(rest, 16, 1, 2),
        'u' => number(rest, 16, 4, 4),
        'U' => number(rest, 16, 8, 8),
        _ => number(text, 8, 1, 3),
    }
}

fn number(text: &str, radix: u32, least: usize, most: usize) -> IResult<&str, u32> {
    let (rest, digits) = take_while_m_n(least, most, |c: char| c.is_digit(radix)).parse(text)?;
    // Eight hexadecimal digits always fit.
    Ok((rest, u32::from_str_radix(digits, radix).unwrap_or(u32::MAX)))
}
