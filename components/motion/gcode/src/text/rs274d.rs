//! A line of RS274-D: commands and words, each with its place.
//!
//! A line is `[N] { comment | command | word }`. A command is G, M or S with digits; a word is one of
//! `A B C D F H I J K L P Q R T X Y Z` with a decimal number. Blanks mean nothing. `#` begins a comment to the end of the
//! line; `( … )` and `(* … *)` are comments.

use crate::{
    error::Problem,
    text::number::{number, unsigned},
};

/// The most digits of a line number.
const NUMBER_DIGITS: usize = 5;

/// A command or a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// The letter, in lower case.
    pub letter: u8,
    /// The number behind it; a whole one behind G, M and S.
    pub value: f64,
    /// The place: bytes of the line before it.
    pub at: usize,
}

/// A parsed line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// The N number.
    pub number: Option<u32>,
    /// Commands and words in their order.
    pub items: Vec<Item>,
}

/// A byte that stands in the place of a comment: numbers do not contain it.
const GAP: u8 = b'(';

/// Parses a line.
///
/// # Errors
/// The place of a problem, in bytes, and the problem.
pub fn parse(raw: &[u8]) -> Result<Line, (usize, Problem)> {
    let (text, places) = clean(raw)?;
    let place = |index: usize| places.get(index).copied().unwrap_or(raw.len());
    // Behind the last byte, the place is behind its letter.
    let behind = |index: usize| places.get(index + 1).copied().unwrap_or(place(index) + 1);
    let mut line = Line::default();
    let mut at = 0;
    let mut is_first = true;
    while let Some(rest) = text.get(at..).filter(|r| !r.is_empty()) {
        let (letter, after) = rest.split_first().unwrap_or((&GAP, &[]));
        let left = match *letter {
            GAP => after,
            b'n' if is_first => {
                let (left, value) = unsigned(after).map_err(|e| (behind(at), problem(e)))?;
                if after.len() - left.len() > NUMBER_DIGITS {
                    return Err((place(at), Problem::LineNumberLong));
                }
                line.number = Some(value);
                left
            }
            b'g' | b'm' | b's' => {
                let digits = after.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
                let (left, value) = unsigned(after).map_err(|e| (behind(at), problem(e)))?;
                if after.len() - left.len() < digits {
                    let code = after.get(..digits).unwrap_or_default();
                    let code = String::from_utf8_lossy(code);
                    let what = format!("{}{code}", upper(*letter)).into();
                    return Err((place(at), Problem::NotInDialect { what }));
                }
                line.items.push(Item { letter: *letter, value: f64::from(value), at: place(at) });
                left
            }
            b'a'..=b'd' | b'f' | b'h'..=b'l' | b'p' | b'q' | b'r' | b't' | b'x'..=b'z' => {
                let (left, value) = number(after).map_err(|e| (behind(at), problem(e)))?;
                line.items.push(Item { letter: *letter, value, at: place(at) });
                left
            }
            other => return Err((place(at), stranger(other))),
        };
        is_first &= *letter == GAP;
        at = text.len() - left.len();
    }
    Ok(line)
}

/// Returns the line in lower case without blanks, and with a [`GAP`] for each comment; and the place of each byte.
fn clean(raw: &[u8]) -> Result<(Vec<u8>, Vec<usize>), (usize, Problem)> {
    let (mut text, mut places) = (Vec::new(), Vec::new());
    let mut at = 0;
    while let Some(byte) = raw.get(at).copied() {
        match byte {
            b'#' => break,
            b'(' => {
                let inner = raw.get(at + 1..).unwrap_or_default();
                let end: &[u8] = if inner.first() == Some(&b'*') { b"*)" } else { b")" };
                // The star that begins a comment does not end it too.
                let from = end.len() - 1;
                let found = inner.get(from..).unwrap_or_default().windows(end.len());
                let Some(length) = found.into_iter().position(|w| w == end) else {
                    return Err((at, Problem::UnclosedComment));
                };
                text.push(GAP);
                places.push(at);
                at += from + length + end.len();
            }
            b' ' | b'\t' | b'\r' | b'\n' => {}
            _ => {
                text.push(byte.to_ascii_lowercase());
                places.push(at);
            }
        }
        at += 1;
    }
    Ok((text, places))
}

/// Returns the problem of a byte that begins neither a command nor a word.
fn stranger(byte: u8) -> Problem {
    let what = match byte {
        b'o' => "O, for subroutines and loops,".into(),
        b'n' => "N behind other words".into(),
        b'%' => "%".into(),
        b'/' => "/, for lines that can be left out,".into(),
        b';' => "; for a comment".into(),
        b'[' | b']' => "an expression in [ ]".into(),
        b'=' => "a parameter".into(),
        b'a'..=b'z' => format!("the word {}", upper(byte)).into(),
        _ => return Problem::of_byte(Some(byte)),
    };
    Problem::NotInDialect { what }
}

fn problem(error: nom::Err<super::Fault<'_>>) -> Problem {
    match error {
        nom::Err::Error(fault) | nom::Err::Failure(fault) => fault.problem,
        nom::Err::Incomplete(_) => Problem::NoNumber,
    }
}

/// Returns the letter as messages show it.
pub(crate) fn upper(letter: u8) -> char {
    char::from(letter.to_ascii_uppercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> String {
        match parse(text.as_bytes()) {
            Ok(line) => {
                let number = line.number.map(|n| format!("N{n} ")).unwrap_or_default();
                let items = line
                    .items
                    .iter()
                    .map(|i| format!("{}{}@{}", char::from(i.letter), i.value, i.at));
                number + &items.collect::<Vec<_>>().join(" ")
            }
            Err((at, problem)) => format!("{at}: {problem}"),
        }
    }

    #[test]
    fn the_grammar_line_by_line() {
        for (text, wanted) in [
            ("", ""),
            ("   \t\r", ""),
            ("# G00 X1", ""),
            ("(* G00 ) # *)", ""),
            ("(*) x *)", ""),
            ("(a) G00 (b) X1 (c", "15: Unclosed comment found"),
            ("(* a )", "0: Unclosed comment found"),
            ("(*)", "0: Unclosed comment found"),
            ("G00 X0Y0", "g0@0 x0@4 y0@6"),
            ("g 0 0 z 0.125", "g0@0 z0.125@6"),
            ("X8 Y.25", "x8@0 y0.25@3"),
            ("I-.5 J+5.", "i-0.5@0 j5@5"),
            ("N99999 G01", "N99999 g1@7"),
            ("n 1 2 g1", "N12 g1@6"),
            ("(c) N5 G1", "N5 g1@7"),
            ("N123456 G01", "0: line number has more than 5 digits"),
            ("N-1", "1: Bad format unsigned integer"),
            ("G1 N5", "3: N behind other words is not part of RS274-D"),
            ("N1 N2", "3: N behind other words is not part of RS274-D"),
            ("S1500 M03 T1", "s1500@0 m3@6 t1@10"),
            ("G5.1 X1", "0: G5.1 is not part of RS274-D"),
            ("G.5", "1: Bad format unsigned integer"),
            ("G-1", "1: Bad format unsigned integer"),
            ("G", "1: Bad format unsigned integer"),
            ("X", "1: No characters found in reading real value"),
            ("X.", "1: bad number format (conversion failed) parsing '.'"),
            ("X1(c)5", "5: Bad character '5' used"),
            ("X1e5", "2: the word E is not part of RS274-D"),
            ("X1 U2", "3: the word U is not part of RS274-D"),
            ("X[1+2]", "1: bad number format (conversion failed) parsing ''"),
            ("X1 = 2", "3: a parameter is not part of RS274-D"),
            ("O100", "0: O, for subroutines and loops, is not part of RS274-D"),
            ("%", "0: % is not part of RS274-D"),
            ("/G0", "0: /, for lines that can be left out, is not part of RS274-D"),
            ("G0 ; c", "3: ; for a comment is not part of RS274-D"),
            ("IN;SP1;PU0,0;", "1: bad number format (conversion failed) parsing ''"),
            ("*%FSLAX24Y24*%", "0: Bad character '*' used"),
            ("X99999999999999999999", "x100000000000000000000@0"),
            ("G99999999999", "1: number is too large"),
        ] {
            assert_eq!(shown(text), wanted, "{text}");
        }
    }
}
