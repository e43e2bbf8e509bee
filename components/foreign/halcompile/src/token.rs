//! Tokens of the language: names, numbers and strings, and the blanks and comments between them.

use crate::Problem;
use nom::{
    IResult, Parser,
    branch::alt,
    bytes::complete::{tag, take_till, take_until, take_while},
    character::complete::{multispace1, satisfy},
    combinator::{recognize, value},
    error::{ErrorKind, ParseError},
    multi::many0,
};

/// Reason why a parser did not match: what it expected, and the position.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Miss {
    /// Number of bytes from the position to the end.
    pub(crate) left: usize,
    /// Number of bytes that the message marks.
    pub(crate) long: usize,
    /// Tokens that would have been valid.
    pub(crate) wanted: Vec<&'static str>,
    /// More specific problem, if there is one.
    pub(crate) problem: Option<Box<Problem>>,
}

impl Miss {
    /// Reports that something else was expected here.
    pub(crate) fn wanted(input: &str, wanted: &'static str) -> Self {
        Self { left: input.len(), long: found(input).len(), wanted: vec![wanted], problem: None }
    }

    /// Reports a problem with the text from `start`, `long` bytes of it.
    pub(crate) fn problem(start: &str, long: usize, problem: Problem) -> Self {
        Self { left: start.len(), long, wanted: Vec::new(), problem: Some(Box::new(problem)) }
    }
}

impl ParseError<&str> for Miss {
    fn from_error_kind(input: &str, _: ErrorKind) -> Self {
        Self { left: input.len(), long: 0, wanted: Vec::new(), problem: None }
    }

    fn append(_: &str, _: ErrorKind, other: Self) -> Self {
        other
    }

    fn or(mut self, other: Self) -> Self {
        if self.left == other.left {
            self.wanted.extend(other.wanted);
            self.problem = self.problem.or(other.problem);
            return self;
        }
        if self.left < other.left { self } else { other }
    }
}

/// Result of a parser of this language.
pub(crate) type Parsed<'a, T> = IResult<&'a str, T, Miss>;

pub(crate) fn fail<T>(miss: Miss) -> Parsed<'static, T> {
    Err(nom::Err::Error(miss))
}

pub(crate) fn stop<T>(miss: Miss) -> Parsed<'static, T> {
    Err(nom::Err::Failure(miss))
}

/// Returns the word or character at the input, for a message.
pub(crate) fn found(input: &str) -> &str {
    let word = input.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(input.len());
    let first = input.chars().next().map_or(0, char::len_utf8);
    input.get(..word.max(first)).unwrap_or_default()
}

/// Parses blanks and comments.
pub(crate) fn blank(input: &str) -> Parsed<'_, ()> {
    let comment = alt((
        recognize((tag("//"), take_till(|c| c == '\n'))),
        recognize((tag("/*"), take_until("*/"), tag("*/"))),
    ));
    let (rest, ()) = value((), many0(alt((multispace1, comment)))).parse(input)?;
    if rest.starts_with("/*") {
        return stop(Miss::problem(rest, 2, Problem::UnclosedComment));
    }
    Ok((rest, ()))
}

/// Returns a parser that also skips the blanks after its result.
pub(crate) fn then_blank<'a, T>(
    mut parser: impl FnMut(&'a str) -> Parsed<'a, T>,
) -> impl FnMut(&'a str) -> Parsed<'a, T> {
    move |input| {
        let (rest, out) = parser(input)?;
        let (rest, ()) = blank(rest)?;
        Ok((rest, out))
    }
}

/// Returns a parser for a sign such as `;` or `<<`; messages show `wanted`, the sign in quotes.
pub(crate) fn sign<'a>(
    text: &'static str,
    wanted: &'static str,
) -> impl FnMut(&'a str) -> Parsed<'a, &'a str> {
    then_blank(move |input: &'a str| match input.strip_prefix(text) {
        Some(rest) => Ok((rest, input.get(..text.len()).unwrap_or_default())),
        None => fail(Miss::wanted(input, wanted)),
    })
}

/// Parses a C name.
pub(crate) fn c_word(input: &str) -> Parsed<'_, &str> {
    recognize((satisfy(starts_name), take_while(|c: char| c.is_ascii_alphanumeric() || c == '_')))
        .parse(input)
}

/// Parses a HAL name.
pub(crate) fn hal_word(input: &str) -> Parsed<'_, &str> {
    recognize((
        satisfy(|c| starts_name(c) || c == '#'),
        take_while(|c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.' | '#')),
    ))
    .parse(input)
}

const fn starts_name(c: char) -> bool {
    c.is_ascii_alphabetic() || c == '_'
}

/// Returns a parser for one given word.
pub(crate) fn keyword<'a>(
    text: &'static str,
    wanted: &'static str,
) -> impl FnMut(&'a str) -> Parsed<'a, &'a str> {
    then_blank(move |input: &'a str| match c_word(input) {
        Ok((rest, word)) if word == text => Ok((rest, word)),
        _ => fail(Miss::wanted(input, wanted)),
    })
}

/// Parses integers in any of their four bases, with or without sign.
pub(crate) fn whole(input: &str) -> Parsed<'_, i128> {
    let (rest, minus) = signed(input);
    let (base, digits) = match rest.as_bytes() {
        [b'0', b'x' | b'X', ..] => (16, rest.get(2..).unwrap_or_default()),
        [b'0', b'b' | b'B', ..] => (2, rest.get(2..).unwrap_or_default()),
        [b'0', b'o' | b'O', ..] => (8, rest.get(2..).unwrap_or_default()),
        _ => (10, rest),
    };
    let long = digits.find(|c: char| !c.is_digit(base)).unwrap_or(digits.len());
    let (number, rest) = digits.split_at_checked(long).unwrap_or_default();
    if number.is_empty() {
        return fail(Miss::wanted(input, "a number"));
    }
    match i128::from_str_radix(number, base) {
        // The range of all 64-bit numbers of either sign, with reserve for arithmetic in messages.
        Ok(n) if n <= i128::from(u64::MAX) => Ok((rest, if minus { -n } else { n })),
        _ => stop(Miss::problem(
            input,
            input.len() - rest.len(),
            Problem::NumberTooLarge {
                number: input.get(..input.len() - rest.len()).unwrap_or_default().into(),
            },
        )),
    }
}

/// Parses numbers with a decimal point, an exponent, or C's suffix `f`.
pub(crate) fn real(input: &str) -> Parsed<'_, f64> {
    let (rest, minus) = signed(input);
    let mut long = digits(rest);
    let mut is_real = false;
    let mut any = long > 0;
    let tail = |n: usize| rest.get(n..).unwrap_or_default();
    if tail(long).starts_with('.') {
        let behind = digits(tail(long + 1));
        any |= behind > 0;
        is_real = true;
        long += 1 + behind;
    }
    if let Some(exponent) = tail(long).strip_prefix(['e', 'E']) {
        let sign = usize::from(exponent.starts_with(['+', '-']));
        let power = digits(exponent.get(sign..).unwrap_or_default());
        if power > 0 {
            is_real = true;
            long += 1 + sign + power;
        }
    }
    let f = usize::from(tail(long).starts_with(['f', 'F']));
    let number = rest.get(..long).unwrap_or_default().parse::<f64>();
    match number {
        Ok(n) if any && n.is_infinite() => {
            let long = input.len() - tail(long).len();
            let number = input.get(..long).unwrap_or_default().into();
            stop(Miss::problem(input, long, Problem::NumberTooLarge { number }))
        }
        Ok(n) if any && (is_real || f == 1) => Ok((tail(long + f), if minus { -n } else { n })),
        _ => fail(Miss::wanted(input, "a number")),
    }
}

fn signed(input: &str) -> (&str, bool) {
    match input.strip_prefix('-') {
        Some(rest) => (rest, true),
        None => (input.strip_prefix('+').unwrap_or(input), false),
    }
}

fn digits(input: &str) -> usize {
    input.find(|c: char| !c.is_ascii_digit()).unwrap_or(input.len())
}

/// Parses a string: `"…"` with escapes, `"""…"""` of several lines, `r"""…"""` without escapes.
pub(crate) fn text(input: &str) -> Parsed<'_, String> {
    let (rest, raw) = match input.strip_prefix('r') {
        Some(rest) if rest.starts_with('"') => (rest, true),
        _ => (input, false),
    };
    if let Some(rest) = rest.strip_prefix("\"\"\"") {
        return match closed(rest, "\"\"\"", raw) {
            Some(long) => ended(rest, long, 3, raw),
            None => stop(Miss::problem(input, input.len() - rest.len(), Problem::UnclosedLongText)),
        };
    }
    let Some(rest) = rest.strip_prefix('"') else {
        return fail(Miss::wanted(input, "a text in \"…\""));
    };
    // A backslash at the end of a line joins it and the next.
    let end = if raw { rest.find('\n') } else { closed(rest, "\n", false) };
    let line = end.map_or(rest, |end| rest.get(..end).unwrap_or_default());
    match closed(line, "\"", raw) {
        Some(long) => ended(rest, long, 1, raw),
        None => {
            stop(Miss::problem(input, input.len() - rest.len() + line.len(), Problem::UnclosedText))
        }
    }
}

/// Returns the length of a string before its closing quotes; a backslash escapes the next character.
fn closed(text: &str, quotes: &str, raw: bool) -> Option<usize> {
    let mut skip = false;
    text.char_indices().find_map(|(i, c)| {
        if skip {
            skip = false;
            return None;
        }
        skip = c == '\\' && !raw;
        text.get(i..).is_some_and(|t| t.starts_with(quotes)).then_some(i)
    })
}

fn ended(text: &str, long: usize, quotes: usize, raw: bool) -> Parsed<'_, String> {
    let (inside, rest) = text.split_at_checked(long).unwrap_or_default();
    let rest = rest.get(quotes..).unwrap_or_default();
    if raw { Ok((rest, inside.to_owned())) } else { Ok((rest, unescaped(inside, text)?)) }
}

/// Returns the string as C would see it.
fn unescaped(mut inside: &str, whole: &str) -> Result<String, nom::Err<Miss>> {
    let mut out = String::new();
    let total = inside.len();
    while let Some(at) = inside.find('\\') {
        let (before, rest) = inside.split_at_checked(at).unwrap_or_default();
        out.push_str(before);
        let Some((long, c)) = escape(rest) else {
            let start = whole.get(total - rest.len()..).unwrap_or_default();
            let long = 1 + rest.chars().nth(1).map_or(0, char::len_utf8);
            let escape = rest.get(..long).unwrap_or_default().into();
            return Err(nom::Err::Failure(Miss::problem(start, long, Problem::Escape { escape })));
        };
        out.extend(c);
        inside = rest.get(long..).unwrap_or_default();
    }
    out.push_str(inside);
    Ok(out)
}

/// Returns the length of an escape, and the character it represents.
fn escape(text: &str) -> Option<(usize, Option<char>)> {
    let mut chars = text.chars().skip(1);
    let first = chars.next()?;
    let number = |from: usize, most: usize, base: u32| {
        let digits = text.get(from..).unwrap_or_default();
        let long = digits.find(|c: char| !c.is_digit(base)).unwrap_or(digits.len()).min(most);
        let code = u32::from_str_radix(digits.get(..long)?, base).ok()?;
        Some((from + long, Some(char::from_u32(code)?)))
    };
    let plain = |c| Some((1 + first.len_utf8(), Some(c)));
    match first {
        'n' => plain('\n'),
        't' => plain('\t'),
        'r' => plain('\r'),
        'a' => plain('\x07'),
        'b' => plain('\x08'),
        'f' => plain('\x0c'),
        'v' => plain('\x0b'),
        '\\' | '"' | '\'' | '?' => plain(first),
        '\n' => Some((2, None)),
        'x' => number(2, 2, 16),
        'u' => number(2, 4, 16),
        'U' => number(2, 8, 16),
        '0'..='7' => number(1, 3, 8),
        // Markup of manual pages and of reST, such as \fB, \- and \|, is kept.
        _ if first.is_ascii() => Some((1, Some('\\'))),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers() {
        let of = |t| whole(t).ok();
        assert_eq!(of("0x1F;"), Some((";", 31)));
        assert_eq!(of("-0b101"), Some(("", -5)));
        assert_eq!(of("0o17 "), Some((" ", 15)));
        assert_eq!(of("18446744073709551615"), Some(("", i128::from(u64::MAX))));
        assert_eq!(of("18446744073709551616"), None);
        assert_eq!(of("x"), None);
        let of = |t| real(t).ok();
        assert_eq!(of("1.5f;"), Some((";", 1.5)));
        assert_eq!(of("-.5e-3"), Some(("", -0.0005)));
        assert_eq!(of("2."), Some(("", 2.0)));
        assert_eq!(of("3"), None);
        assert_eq!(of("3f"), Some(("", 3.0)));
        assert_eq!(of("."), None);
    }

    #[test]
    fn texts() {
        let of = |t| text(t).ok();
        assert_eq!(of(r#""a \"b\" \\ \x41\101\n";"#), Some((";", "a \"b\" \\ AA\n".into())));
        assert_eq!(of("\"\"\"two\n\"lines\" \"\"\" x"), Some((" x", "two\n\"lines\" ".into())));
        assert_eq!(of(r#"r"""\fB\n""""#), Some(("", "\\fB\\n".into())));
        assert_eq!(of(r#""\-1""#), Some(("", "\\-1".into())));
        assert_eq!(of("\"joined \\\nline\";"), Some((";", "joined line".into())));
        assert_eq!(of("\"open\n\""), None);
        assert_eq!(of("\"\\é\""), None);
    }
}
