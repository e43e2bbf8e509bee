//! Words of a trigger text.

use super::ConditionError;
use nom::{
    IResult, Parser,
    branch::alt,
    bytes::complete::{tag, take_till, take_till1},
    character::complete::multispace0,
    combinator::map,
    sequence::delimited,
};

/// Kind of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A name, a number, or a keyword.
    Word,
    /// A name in quotes, which is never a keyword.
    Quoted,
    /// An operator or a parenthesis.
    Sign,
}

/// A word and its position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Word<'a> {
    pub(super) kind: Kind,
    pub(super) text: &'a str,
    pub(super) at: usize,
    pub(super) length: usize,
}

/// Splits a text into words.
pub(super) fn words(text: &str) -> Result<Vec<Word<'_>>, ConditionError> {
    let mut rest = text;
    let mut words = Vec::new();
    loop {
        let blank: IResult<&str, &str> = multispace0(rest);
        rest = blank.map_or(rest, |(rest, _)| rest);
        if rest.is_empty() {
            return Ok(words);
        }
        let at = text.len() - rest.len();
        let Ok((after, (kind, found))) = word(rest) else {
            let (length, why) = if rest.starts_with(['"', '\'']) {
                (rest.trim_end().len(), "a quote that does not end")
            } else {
                (1, "this means nothing in a trigger")
            };
            return Err(ConditionError::new(text, at, length, why));
        };
        words.push(Word { kind, text: found, at, length: rest.len() - after.len() });
        rest = after;
    }
}

fn word(text: &str) -> IResult<&str, (Kind, &str)> {
    let quoted = |quote: char| {
        let sign: &'static str = if quote == '"' { "\"" } else { "'" };
        delimited(tag(sign), take_till(move |c| c == quote), tag(sign))
    };
    let signs = alt((
        tag("("),
        tag(")"),
        tag("<="),
        tag(">="),
        tag("=="),
        tag("!="),
        tag("<>"),
        tag("<"),
        tag(">"),
        tag("="),
        tag("&&"),
        tag("||"),
        tag("!"),
    ));
    let plain = |c: char| c.is_whitespace() || "()<>=!&|\"'".contains(c);
    let bare = take_till1(plain);
    alt((
        map(quoted('\''), |t| (Kind::Quoted, t)),
        map(quoted('"'), |t| (Kind::Quoted, t)),
        map(signs, |t| (Kind::Sign, t)),
        map(bare, |t| (Kind::Word, t)),
    ))
    .parse(text)
}
