//! A line as a list of words, assignments and comments, or an O-word.

use crate::{
    error::Problem,
    text::{
        Fault, Input, Parsed, comment,
        expression::{Expr, Left, angled, left, value},
        fail,
        number::{number, unsigned},
        oword::{self, OWord},
    },
};

/// A word: a letter and a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    /// The letter in lower case, or `$`, `@`, `^`.
    pub letter: u8,
    /// The place of the letter.
    pub at: Left,
    /// The value.
    pub value: Expr,
}

/// The target of an assignment.
#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    /// `#n`
    Numbered(Expr),
    /// `#<name>`
    Named(Box<str>),
}

/// A comment in brackets.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// The meaning.
    pub kind: comment::Kind,
    /// The text behind the word of the meaning.
    pub text: Box<str>,
}

/// A parsed line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// The line begins with `/`.
    pub deletable: bool,
    /// The N number.
    pub number: Option<u32>,
    /// The O-word; there are no other words then.
    pub oword: Option<OWord>,
    /// The words in their order.
    pub words: Vec<Word>,
    /// The assignments in their order.
    pub assignments: Vec<(Left, Target, Expr)>,
    /// The last comment in brackets.
    pub remark: Option<Remark>,
}

impl Line {
    /// Parses a cleaned line into `self` and reuses its memory.
    pub fn parse<'a>(&mut self, cleaned: Input<'a>) -> Result<(), Fault<'a>> {
        self.deletable = false;
        self.number = None;
        self.oword = None;
        self.words.clear();
        self.assignments.clear();
        self.remark = None;
        self.items(cleaned).map(|_| ()).map_err(|e| match e {
            nom::Err::Error(f) | nom::Err::Failure(f) => f,
            nom::Err::Incomplete(_) => Fault { at: cleaned, problem: Problem::NoNumber },
        })
    }

    fn items<'a>(&mut self, cleaned: Input<'a>) -> Parsed<'a, ()> {
        let mut rest = cleaned;
        if let [b'/', after @ ..] = rest {
            self.deletable = true;
            rest = after;
        }
        if let [b'n', after @ ..] = rest {
            let (after, n) = unsigned(after)?;
            self.number = Some(n);
            rest = match after {
                // A fraction of a line number is read and has no meaning.
                [b'.', ..] => number(after)?.0,
                _ => after,
            };
        }
        if let [b'o', after @ ..] = rest {
            let (after, label) = oword::label(after)?;
            let (after, action) = oword::action(after)?;
            self.oword = Some(OWord { label, action });
            return self.trailing(after);
        }
        while let Some(first) = rest.first().copied() {
            rest = match first {
                b'(' | b';' => self.comment(rest),
                b'#' => self.assignment(rest)?.0,
                _ => self.word(rest, first)?.0,
            };
        }
        Ok((rest, ()))
    }

    /// Tells whether nothing of the line was read yet.
    fn is_blank(&self) -> bool {
        let is_marked = self.deletable || self.number.is_some() || self.oword.is_some();
        !is_marked && self.words.is_empty() && self.assignments.is_empty() && self.remark.is_none()
    }

    /// Reads what may follow an O-word: comments only.
    fn trailing<'a>(&mut self, mut rest: Input<'a>) -> Parsed<'a, ()> {
        while let Some(first) = rest.first() {
            if !matches!(first, b'(' | b';') {
                return fail(rest, Problem::AfterOWord);
            }
            rest = self.comment(rest);
        }
        Ok((rest, ()))
    }

    fn comment<'a>(&mut self, input: Input<'a>) -> Input<'a> {
        let (mark, inner) = input.split_first().unwrap_or((&b';', &[]));
        if *mark == b';' {
            // It ends the line; a comment in brackets before it keeps its meaning.
            if inner.starts_with(b"py,") && self.is_blank() {
                self.remark = Some(Remark { kind: comment::Kind::Python, text: Box::default() });
            }
            return &[];
        }
        let end = inner.iter().position(|b| *b == b')').unwrap_or(inner.len());
        let (text, rest) = inner.split_at_checked(end).unwrap_or((inner, &[]));
        let text = String::from_utf8_lossy(text);
        let (kind, text) = comment::classify(&text);
        // An empty comment is none, unlike one of blanks.
        self.remark = (end > 0).then(|| Remark { kind, text: text.into() });
        rest.get(1..).unwrap_or_default()
    }

    fn assignment<'a>(&mut self, input: Input<'a>) -> Parsed<'a, ()> {
        let at = left(input);
        let after = input.get(1..).unwrap_or_default();
        let (rest, target) = if after.first() == Some(&b'<') {
            let (rest, name) = angled(after)?;
            (rest, Target::Named(name))
        } else {
            let (rest, index) = value(after)?;
            (rest, Target::Numbered(index))
        };
        let Some((b'=', rest)) = rest.split_first() else {
            return fail(rest, Problem::NoEqualSign);
        };
        let (rest, expr) = value(rest)?;
        self.assignments.push((at, target, expr));
        Ok((rest, ()))
    }

    fn word<'a>(&mut self, input: Input<'a>, letter: u8) -> Parsed<'a, ()> {
        let known = matches!(letter, b'a'..=b'm' | b'p'..=b'z' | b'$' | b'@' | b'^');
        if !known {
            return fail(input, Problem::of_byte(Some(letter)));
        }
        let (rest, expr) = value(input.get(1..).unwrap_or_default())?;
        self.words.push(Word { letter, at: left(input), value: expr });
        Ok((rest, ()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::oword::{Action, Label};

    fn parse(text: &str) -> Result<Line, Problem> {
        let mut cleaned = Vec::new();
        crate::text::clean::clean(text.as_bytes(), &mut cleaned).map_err(|e| e.1)?;
        let mut line = Line::default();
        line.parse(&cleaned).map_err(|f| f.problem)?;
        Ok(line)
    }

    #[test]
    fn a_line_has_words_assignments_and_a_comment() {
        let line = parse("/N10 G0 X 1 . 5 #1=[2+3] (MSG, a) Y-#1").unwrap();
        assert!(line.deletable);
        assert_eq!(line.number, Some(10));
        let letters: Vec<u8> = line.words.iter().map(|w| w.letter).collect();
        assert_eq!(letters, b"gxy");
        assert_eq!(line.assignments.len(), 1);
        assert_eq!(line.remark.map(|r| r.text), Some(" a".into()));
    }

    #[test]
    fn o_words_are_whole_lines() {
        let line = parse("o<Foo Bar> call [1] (c) [2]").unwrap();
        let word = line.oword.unwrap();
        assert_eq!(word.label, Label::Name("foobar".into()));
        assert!(matches!(word.action, Action::Call(list) if list.len() == 2));
        assert_eq!(parse("o1 if [1] g0"), Err(Problem::AfterOWord));
        assert_eq!(parse("o1 foo"), Err(Problem::UnknownOCommand));
    }
}
