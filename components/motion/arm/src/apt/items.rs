//! Arguments of a statement: words, numbers and groups in brackets.

use super::{
    Error, Problem,
    scan::{Char, at, shown},
};

/// Largest magnitude of a number.
const LARGEST: f64 = 1e7;

/// Word or number of a statement.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Item {
    Word(String),
    Number(f64),
    /// Word with the items after its slash, in brackets.
    Group(String, Vec<f64>),
}

/// Item, and the place where it begins.
pub(super) type Placed = (Item, Char);

/// Returns the words of a statement.
pub(super) fn words(given: &[Placed]) -> Vec<&str> {
    let mut out = Vec::new();
    for (item, _) in given {
        if let Item::Word(word) = item {
            out.push(word.as_str());
        }
    }
    out
}

/// Returns the numbers of a statement that has nothing else.
pub(super) fn numbers(
    given: &[Placed],
    count: core::ops::RangeInclusive<usize>,
    first: &Char,
    word: &'static str,
    takes: &'static str,
) -> Result<Vec<f64>, Error> {
    let mut out = Vec::new();
    for (item, place) in given {
        match item {
            Item::Number(x) => out.push(*x),
            Item::Word(text) | Item::Group(text, _) => {
                return Err(at(place, Problem::Number(text.clone())));
            }
        }
    }
    if count.contains(&out.len()) { Ok(out) } else { Err(at(first, Problem::Count(word, takes))) }
}

/// Splits the arguments of a statement at commas and slashes outside brackets.
pub(super) fn items(chars: &[Char]) -> Result<Vec<Placed>, Error> {
    let mut out = Vec::new();
    let mut rest = chars;
    while let Some((first, _)) = rest.split_first() {
        let (item, after) = if first.byte == b'(' {
            let close = rest.iter().position(|c| c.byte == b')');
            let close = close.ok_or_else(|| at(first, Problem::Bracket))?;
            let inside = rest.get(1..close).unwrap_or_default();
            (group(inside, first)?, rest.get(close + 1..).unwrap_or_default())
        } else {
            let end = rest.iter().position(|c| matches!(c.byte, b',' | b'/' | b'(' | b')'));
            let (token, after) =
                rest.split_at_checked(end.unwrap_or(rest.len())).unwrap_or((rest, &[]));
            (single(token, first)?, after)
        };
        out.push((item, *first));
        rest = match after.split_first() {
            None => after,
            // A separator is followed by another item.
            Some((c, [])) if c.byte == b',' => return Err(at(c, Problem::Number(String::new()))),
            Some((c, after)) if matches!(c.byte, b',' | b'/') => after,
            Some((c, _)) => return Err(at(c, Problem::Bracket)),
        };
    }
    Ok(out)
}

fn group(inside: &[Char], first: &Char) -> Result<Item, Error> {
    let slash =
        inside.iter().position(|c| c.byte == b'/').ok_or_else(|| at(first, Problem::NoWord))?;
    let (word, rest) = inside.split_at_checked(slash).unwrap_or((inside, &[]));
    let mut numbers = Vec::new();
    for token in rest.get(1..).unwrap_or_default().split(|c| c.byte == b',') {
        let place = token.first().unwrap_or(first);
        match single(token, place)? {
            Item::Number(x) => numbers.push(x),
            Item::Word(_) | Item::Group(..) => {
                return Err(at(place, Problem::Number(shown(token))));
            }
        }
    }
    Ok(Item::Group(shown(word), numbers))
}

/// Reads a word or a number.
fn single(token: &[Char], place: &Char) -> Result<Item, Error> {
    let text: String = token.iter().map(|c| char::from(c.byte)).collect();
    let is_word = text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.chars().all(|c| c.is_ascii_alphanumeric());
    if is_word {
        return Ok(Item::Word(shown(token)));
    }
    let is_number = text.chars().all(|c| c.is_ascii_digit() || "+-.ED".contains(c));
    let number = if is_number { text.replace('D', "E").parse::<f64>().ok() } else { None };
    match number {
        None => Err(at(place, Problem::Number(shown(token)))),
        Some(x) if x.abs() <= LARGEST => Ok(Item::Number(x)),
        Some(_) => Err(at(place, Problem::Range(shown(token)))),
    }
}
