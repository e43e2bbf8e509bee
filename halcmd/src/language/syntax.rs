//! The syntax tree of a line: words and their positions.

use crate::{
    Command, Error,
    language::fault::{Fault, Span, blamed},
    language::lex::{self, Line, spans, uncomment},
    language::table,
    language::vars::{Values, replaced},
    terminal::colour::visible,
};

/// A line as words, without the comment and with variables replaced.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Statement {
    words: Vec<String>,
    spans: Vec<Span>,
    /// Position of a further word.
    end: usize,
}

impl Statement {
    /// Parses a line.
    ///
    /// # Errors
    /// A quote is not closed, a variable is wrong, or there are too many words.
    pub fn parse(line: &str, values: Values<'_>) -> Result<Self, Fault> {
        let text = uncomment(line)?;
        let text = replaced(text, values)?;
        let found = spans(&text.text)
            .map_err(|fault| Fault { at: fault.at.map(|at| text.origin(&at)), ..fault })?;
        let word = |span: &Span| text.text.get(span.clone()).unwrap_or_default().to_owned();
        let words = found.iter().map(word).collect();
        let spans: Vec<Span> = found.iter().map(|span| text.origin(span)).collect();
        let end = spans.last().map_or(0, |last| last.end);
        Ok(Self { words, spans, end })
    }

    /// Makes a statement from words, and the line that they form.
    #[must_use]
    pub fn of_words(words: &[String]) -> (Self, Line) {
        let mut text = String::new();
        let mut spans = Vec::new();
        for word in words {
            if !text.is_empty() {
                text.push(' ');
            }
            spans.push(text.len()..text.len() + word.len());
            text.push_str(word);
        }
        let end = text.len();
        (Self { words: words.to_vec(), spans, end }, Line::single(0, &text))
    }

    /// Returns the words, with their quotes.
    #[must_use]
    pub fn words(&self) -> &[String] {
        &self.words
    }

    /// Returns the position of a word, in bytes of the joined line. A word from a variable is at
    /// the position of the variable; a word after the last would follow it after one space.
    #[must_use]
    pub fn span(&self, word: usize) -> Span {
        self.spans.get(word).cloned().unwrap_or(self.end + 1..self.end + 2)
    }

    /// Returns whether the first word is `quit` or `exit`, in any case.
    pub(crate) fn ends_input(&self) -> bool {
        let first = self.words.first();
        first.is_some_and(|w| ["quit", "exit"].iter().any(|q| w.eq_ignore_ascii_case(q)))
    }

    /// Parses the words as a command.
    ///
    /// # Errors
    /// There is no such command, or its arguments are wrong.
    pub fn command(&self) -> Result<Command, Fault> {
        table::parse_command(&self.words).map_err(|error| self.blame(error))
    }

    /// Makes a fault for an error, with the position of the words to which it refers.
    pub(crate) fn blame(&self, error: Error) -> Fault {
        let words = blamed(&error, &self.words);
        let (first, last) = (self.span(words.start), self.span(words.end.max(1) - 1));
        let after = if matches!(error, Error::NoFunct | Error::NoThread) {
            vec!["delf failed".to_owned()]
        } else {
            Vec::new()
        };
        Fault { after, ..Fault::at(error, first.start..last.end.max(first.end)) }
    }
}

/// Returns an excerpt of a file for a person: the physical line with marks under the wrong part.
#[must_use]
pub fn excerpt(line: &Line, at: &Span) -> Option<String> {
    /// Width of the excerpt of a long line, and of the part before the error.
    const WIDTH: usize = 100;
    const BEFORE: usize = 40;
    let text = line.text.as_ref().ok()?;
    let piece = line.breaks.iter().filter(|b| **b <= at.start).count();
    let from = piece.checked_sub(1).and_then(|n| line.breaks.get(n)).copied().unwrap_or(0);
    let to = line.breaks.get(piece).copied().unwrap_or(text.len());
    let start = text.get(from..at.start.min(to))?.chars().count();
    let extra = at.start.saturating_sub(to);
    let length = text.get(at.start.min(to)..at.end.min(to))?.chars().count().max(1);
    let continued = if piece < line.breaks.len() { "\\" } else { "" };
    let shown = visible(text.get(from..to)?);
    let (cut, more) =
        if shown.chars().count() > WIDTH { (start.saturating_sub(BEFORE), "…") } else { (0, "") };
    let part: String = shown.chars().skip(cut).take(WIDTH).collect();
    let blank = |c: char| if c == '\t' { '\t' } else { ' ' };
    let margin: String = part.chars().take(start - cut).map(blank).collect();
    let marks = "^".repeat(length.min(WIDTH - (start - cut).min(WIDTH - 1)));
    let after = line.breaks.len() - piece;
    let number = line.number.saturating_sub(u32::try_from(after).unwrap_or(u32::MAX));
    let number = if number == 0 { String::new() } else { number.to_string() };
    let (before, extra) = (if cut > 0 { "…" } else { "" }, " ".repeat(extra));
    let shift = " ".repeat(before.chars().count());
    Some(format!(
        "{number:>5} | {before}{part}{more}{continued}\n      | {shift}{margin}{extra}{marks}\n"
    ))
}

/// Parses all lines of a text.
pub fn statements<'a>(
    text: &[u8],
    values: Values<'a>,
) -> impl Iterator<Item = (Line, Result<Statement, Fault>)> + use<'a> {
    lex::lines(text).into_iter().map(move |line| {
        let parsed = match &line.text {
            Ok(text) => Statement::parse(text, values),
            Err(error) => Err(error.clone().into()),
        };
        (line, parsed)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ini::Ini;

    const INI: &str = "[A]\nX = 5\nTWO = and2.0.in0 and2.0.in1\nLONGER = 123456\n";

    /// Checks every word of a text and the part of the file from which it comes.
    fn check(text: &str, want: &[(&str, &str)]) {
        let ini = Ini::parse("m.ini", INI.as_bytes()).unwrap();
        let values = Values { environment: &|_| Some("v w".to_owned()), ini: Some(&ini) };
        let (line, statement) = statements(text.as_bytes(), values).next().unwrap();
        let statement = statement.unwrap();
        let text = line.text.unwrap();
        let got: Vec<(&str, &str)> = statement
            .words()
            .iter()
            .enumerate()
            .map(|(n, word)| (word.as_str(), text.get(statement.span(n)).unwrap()))
            .collect();
        assert_eq!(got, want);
    }

    #[test]
    fn words_know_where_they_stand() {
        check("setp  a.b\t5 # c", &[("setp", "setp"), ("a.b", "a.b"), ("5", "5")]);
        check("print \"a b\"", &[("print", "print"), ("\"a b\"", "\"a b\"")]);
        check("setp a\\\n.b [A]X", &[("setp", "setp"), ("a.b", "a.b"), ("5", "[A]X")]);
        check("setp a [A](X)00", &[("setp", "setp"), ("a", "a"), ("500", "[A](X)00")]);
        check("setp [A]X y z", &[("setp", "setp"), ("5", "[A]X"), ("y", "y"), ("z", "z")]);
        check("é [A]LONGER ü", &[("é", "é"), ("123456", "[A]LONGER"), ("ü", "ü")]);
        check(
            "net s [A]TWO x",
            &[
                ("net", "net"),
                ("s", "s"),
                ("and2.0.in0", "[A]TWO"),
                ("and2.0.in1", "[A]TWO"),
                ("x", "x"),
            ],
        );
        check("p a$(E)b c", &[("p", "p"), ("av", "a$(E)"), ("wb", "$(E)b"), ("c", "c")]);
        check("\n", &[]);
    }

    /// Returns the excerpt of the first line with a syntax error.
    fn shown(text: &str) -> String {
        let ini = Ini::parse("m.ini", INI.as_bytes()).unwrap();
        let values = Values { environment: &|_| None, ini: Some(&ini) };
        for (line, parsed) in statements(text.as_bytes(), values) {
            let fault = match parsed {
                Err(fault) => fault,
                Ok(statement) if statement.words().is_empty() => continue,
                Ok(statement) => match statement.command() {
                    Err(fault) => fault,
                    Ok(_) => continue,
                },
            };
            let at = fault.at.unwrap();
            return format!("{}\n{}", fault.error, excerpt(&line, &at).unwrap());
        }
        String::new()
    }

    #[test]
    fn errors_point_at_the_word_that_is_wrong() {
        for (text, want) in [
            ("\nstart\nadff x y\n", "Unknown command 'adff'\n    3 | adff x y\n      | ^^^^\n"),
            (
                "linkps a => b c d # e",
                "linkps requires 2 arguments, 4 given\n    1 | linkps a => b c d # e\n      |               ^^^\n",
            ),
            ("setp a", "setp requires 2 arguments, 1 given\n    1 | setp a\n      |        ^\n"),
            (
                "newsig x bitt",
                "Unknown signal type 'bitt'\n    1 | newsig x bitt\n      |          ^^^^\n",
            ),
            (
                "newsig \\\n x \\\n bitt",
                "Unknown signal type 'bitt'\n    3 |  bitt\n      |  ^^^^\n",
            ),
            (
                "newsig x \\\n bitt \\\n\n",
                "Unknown signal type 'bitt'\n    2 |  bitt \\\n      |  ^^^^\n",
            ),
            (
                "setp\t\ta [A]XX",
                "Ini variable '[A]XX' not found.\n    1 | setp\t\ta [A]XX\n      |     \t\t  ^^^^^\n",
            ),
            (
                "newsig [A]X [A]X",
                "Unknown signal type '5'\n    1 | newsig [A]X [A]X\n      |        ^^^^\n",
            ),
            (
                "print \"abc # d",
                "unterminated quoted string\n    1 | print \"abc # d\n      |       ^^^^^^^^\n",
            ),
            ("print $", "Empty variable name.\n    1 | print $\n      |       ^\n"),
            ("print [A", "Missing close square bracket.\n    1 | print [A\n      |       ^^\n"),
            ("delf", "missing function name\n    1 | delf\n      |      ^\n"),
            (
                "loadusr -z x",
                "loadusr: invalid option -- 'z'\n    1 | loadusr -z x\n      |         ^^\n",
            ),
            (
                "print \u{1b}[A",
                "Missing close square bracket.\n    1 | print ·[A\n      |        ^^\n",
            ),
        ] {
            assert_eq!(shown(text), want, "{text:?}");
        }
    }

    #[test]
    fn long_lines_are_shown_around_what_is_wrong() {
        let text = format!("print {} [A]NO {}", "x".repeat(200), "y".repeat(200));
        let shown = shown(&text);
        let lines: Vec<&str> = shown.lines().collect();
        let mark = lines[2].find('^').unwrap();
        let column = lines[1].chars().take_while(|c| *c != '[').count();
        assert_eq!(mark, column, "{shown}");
        assert!(lines[1].chars().count() < 112, "{shown}");
    }
}
