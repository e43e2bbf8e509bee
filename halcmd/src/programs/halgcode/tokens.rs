//! A line of G-code as tokens that keep its comments and the text of its values.

use hal_gcode::text::{
    Input, clean,
    expression::{Expr, angled, value},
    oword,
};

/// A part of a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    /// `/`
    Delete,
    /// `N12`; the number without its letter.
    Number(String),
    /// `o<name>` or `o123`, with what follows in one piece.
    OWord { label: String, rest: String },
    /// A word with its letter in upper case.
    Word(Word),
    /// `#target=value`
    Assignment { target: String, value: Value },
    /// A comment with its marks.
    Comment(String),
    /// `%`
    Percent,
}

/// A word.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Word {
    pub(super) letter: char,
    pub(super) value: Value,
}

/// A value: its text, and the number if it is one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Value {
    pub(super) text: String,
    pub(super) number: Option<f64>,
}

/// Splits a line. `None` if it is no line of the language: the interpreter says why.
pub(super) fn tokens(raw: &[u8]) -> Option<Vec<Token>> {
    let mut cleaned = Vec::new();
    clean::clean(raw, &mut cleaned).ok()?;
    let mut rest: &[u8] = &cleaned;
    let mut out = Vec::new();
    if rest == b"%" {
        return Some(vec![Token::Percent]);
    }
    if let [b'/', after @ ..] = rest {
        out.push(Token::Delete);
        rest = after;
    }
    if let [b'n', after @ ..] = rest {
        let digits = after.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
        let (number, after) = after.split_at_checked(digits)?;
        out.push(Token::Number(text(number)));
        rest = after;
    }
    if let [b'o', after @ ..] = rest {
        let (behind, _) = oword::label(after).ok()?;
        let label = text(after.get(..after.len() - behind.len())?);
        let (end, _) = oword::action(behind).ok()?;
        let words = text(behind.get(..behind.len() - end.len())?);
        out.push(Token::OWord { label, rest: words });
        rest = end;
    }
    while let Some(first) = rest.first().copied() {
        rest = match first {
            b';' => {
                out.push(Token::Comment(text(rest)));
                &[]
            }
            b'(' => {
                let end = rest.iter().position(|b| *b == b')')? + 1;
                out.push(Token::Comment(text(rest.get(..end)?)));
                rest.get(end..)?
            }
            b'#' => {
                let after = rest.get(1..)?;
                let end = if after.first() == Some(&b'<') {
                    angled(after).ok()?.0
                } else {
                    value(after).ok()?.0
                };
                let target = text(rest.get(..rest.len() - end.len())?);
                let (after, value) = read(end.strip_prefix(b"=")?)?;
                out.push(Token::Assignment { target, value });
                after
            }
            b'a'..=b'z' | b'$' | b'@' | b'^' => {
                let (after, value) = read(rest.get(1..)?)?;
                let letter = char::from(first.to_ascii_uppercase());
                out.push(Token::Word(Word { letter, value }));
                after
            }
            _ => return None,
        };
    }
    Some(out)
}

/// Reads a value with its text.
fn read(input: Input<'_>) -> Option<(Input<'_>, Value)> {
    let (rest, tree) = value(input).ok()?;
    let text = text(input.get(..input.len() - rest.len())?);
    let number = match tree {
        Expr::Number(n) => Some(n),
        _ => None,
    };
    Some((rest, Value { text, number }))
}

/// Returns each byte as a character, so that comments of any encoding come out as they went in.
fn text(bytes: &[u8]) -> String {
    bytes.iter().copied().map(char::from).collect()
}

/// Returns the bytes of a text whose characters are bytes.
pub(super) fn bytes(text: &str) -> Vec<u8> {
    text.chars().map(|c| u8::try_from(c).unwrap_or(b'?')).collect()
}

impl Value {
    /// Returns the value in its shortest form: no sign +, no zeros that say nothing.
    pub(super) fn tidy(&self) -> String {
        if self.number.is_none() {
            return self.text.clone();
        }
        let (sign, digits) = match self.text.strip_prefix('-') {
            Some(rest) => ("-", rest),
            None => ("", self.text.trim_start_matches('+')),
        };
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let whole = whole.trim_start_matches('0');
        let fraction = fraction.trim_end_matches('0');
        let whole = if whole.is_empty() { "0" } else { whole };
        let sign = if whole == "0" && fraction.is_empty() { "" } else { sign };
        if fraction.is_empty() {
            format!("{sign}{whole}")
        } else {
            format!("{sign}{whole}.{fraction}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_keeps_its_comments_and_order() {
        let line = tokens(b"/n10 g1 x+01.500(One) #<A b>=[1+ 2]y-.0 ; End").unwrap();
        assert_eq!(line.len(), 8);
        assert_eq!(line[0], Token::Delete);
        assert_eq!(line[1], Token::Number("10".into()));
        let Token::Word(x) = &line[3] else { panic!() };
        assert_eq!((x.letter, x.value.tidy().as_str()), ('X', "1.5"));
        assert_eq!(line[4], Token::Comment("(One)".into()));
        let Token::Word(y) = &line[6] else { panic!() };
        assert_eq!(y.value.tidy(), "0");
        assert_eq!(line[7], Token::Comment("; End".into()));
        assert_eq!(tokens(b"g1 x[").as_ref(), None);
        let call = tokens(b"o<Sub> call [1] [#2] (c)").unwrap();
        let wanted = Token::OWord { label: "<sub>".into(), rest: "call[1][#2](c)".into() };
        assert_eq!(call[0], wanted);
    }
}
