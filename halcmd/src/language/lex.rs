//! Splitting of script lines into words.

use crate::{
    Error, Lines, Physical,
    language::fault::{Fault, Span},
    language::source::Bytes,
};
use hal_protocol::Link;

/// Maximum number of words on a line.
pub const MAX_WORDS: usize = 32;

/// Mark with which some editors begin a file. It means nothing.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// A line after joining: text and line number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Number of its last physical line.
    pub number: u32,
    /// Text of the line.
    pub text: Result<String, Error>,
    /// Offsets in the text at which the second and each further physical line begins.
    pub breaks: Vec<usize>,
    /// True on the first line that ends with CR LF.
    pub dos: bool,
}

impl Line {
    /// Makes a line that consists of one physical line.
    #[must_use]
    pub fn single(number: u32, text: &str) -> Self {
        Self { number, text: Ok(text.to_owned()), breaks: Vec::new(), dos: false }
    }
}

/// Joins physical lines: a `\` before the end of line continues the line.
#[derive(Debug)]
pub struct Reader<L> {
    lines: L,
    joins: bool,
    number: u32,
    dos: bool,
}

impl<L: Lines> Reader<L> {
    /// Reads a file or the terminal.
    pub const fn new(lines: L) -> Self {
        Self { lines, joins: true, number: 0, dos: false }
    }

    /// Reads a file that another one sources. No lines are joined.
    pub const fn plain(lines: L) -> Self {
        Self { lines, joins: false, number: 0, dos: false }
    }

    /// Returns the next line, or `None` at the end. An unfinished continued line at the end is
    /// dropped.
    pub fn next(&mut self, link: &mut dyn Link) -> Option<Line> {
        let mut text = String::new();
        let mut breaks = Vec::new();
        let mut dos = false;
        loop {
            let Physical { mut bytes, ended, mut cut } = self.lines.next(!text.is_empty(), link)?;
            self.number += 1;
            if cut {
                while cut {
                    cut = self.lines.next(true, link).is_some_and(|rest| rest.cut);
                }
                let text = Err(Error::LineTooLong);
                return Some(Line { number: self.number, text, breaks, dos });
            }
            if self.number == 1 && bytes.starts_with(BYTE_ORDER_MARK) {
                bytes.drain(..BYTE_ORDER_MARK.len());
            }
            if ended && bytes.last() == Some(&b'\r') {
                bytes.pop();
                dos |= !self.dos;
                self.dos = true;
            }
            if bytes.contains(&b'\r') {
                let text = Err(Error::CarriageReturn);
                return Some(Line { number: self.number, text, breaks, dos });
            }
            let continues = self.joins && bytes.last() == Some(&b'\\');
            if continues {
                bytes.pop();
            }
            text.push_str(&String::from_utf8_lossy(&bytes));
            if !continues {
                return Some(Line { number: self.number, text: Ok(text), breaks, dos });
            }
            breaks.push(text.len());
        }
    }
}

/// Returns all lines of a text.
#[must_use]
pub fn lines(text: &[u8]) -> Vec<Line> {
    let mut reader = Reader::new(Bytes::new(text.to_vec()));
    core::iter::from_fn(|| reader.next(&mut Nobody)).collect()
}

/// Removes a comment, which begins with a `#` outside quotes.
///
/// # Errors
/// A quote is not closed.
pub fn without_comment(line: &str) -> Result<&str, Error> {
    uncomment(line).map_err(|fault| *fault.error)
}

/// Like [`without_comment`], with the position of an unclosed quote.
pub(crate) fn uncomment(line: &str) -> Result<&str, Fault> {
    let (kept, rest) = split_before(line, |c| c == '#');
    if rest.is_empty() || rest.starts_with('#') { Ok(kept) } else { Err(unclosed(line, rest)) }
}

/// Splits at whitespace. A quoted run keeps its whitespace and its quotes.
///
/// # Errors
/// A quote is not closed, or there are more than [`MAX_WORDS`].
pub fn words(line: &str) -> Result<Vec<String>, Error> {
    let spans = spans(line).map_err(|fault| *fault.error)?;
    Ok(spans.into_iter().filter_map(|span| line.get(span)).map(str::to_owned).collect())
}

/// Returns the positions of the words in a line.
pub(crate) fn spans(line: &str) -> Result<Vec<Span>, Fault> {
    let mut found = Vec::new();
    let mut rest = line.trim_start_matches(blank);
    while !rest.is_empty() {
        let start = line.len() - rest.len();
        if found.len() == MAX_WORDS {
            return Err(Fault::at(Error::TooManyTokens, start..line.trim_end_matches(blank).len()));
        }
        let (word, after) = split_before(rest, blank);
        if word.is_empty() {
            return Err(unclosed(line, rest));
        }
        found.push(start..line.len() - after.len());
        if after.starts_with(['"', '\'']) {
            return Err(unclosed(line, after));
        }
        rest = after.trim_start_matches(blank);
    }
    Ok(found)
}

/// Returns the fault for an unclosed quote at the beginning of `rest`.
fn unclosed(line: &str, rest: &str) -> Fault {
    Fault::at(Error::UnterminatedQuote, line.len() - rest.len()..line.len())
}

/// Returns whether a word is an arrow, which has no effect.
#[must_use]
pub fn is_arrow(word: &str) -> bool {
    matches!(word, "<=" | "=>" | "<=>")
}

const fn blank(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\r' | '\n' | '\x0b' | '\x0c')
}

/// Splits a text before the first character outside quotes that `ends` it, or before a quote that
/// is not closed.
fn split_before(text: &str, ends: impl Fn(char) -> bool) -> (&str, &str) {
    let mut rest = text;
    while let Some(at) = rest.find(|c| matches!(c, '"' | '\'') || ends(c)) {
        rest = rest.get(at..).unwrap_or("");
        let Some(after) = after_quoted(rest) else {
            return text.split_at_checked(text.len() - rest.len()).unwrap_or((text, ""));
        };
        rest = after;
    }
    (text, "")
}

/// Returns the text after a quoted run at the beginning, if there is one and it is closed.
fn after_quoted(text: &str) -> Option<&str> {
    let inside = text.strip_prefix(['"', '\''])?;
    let quote = text.chars().next()?;
    inside.split_once(quote).map(|(_, after)| after)
}

/// A link for texts that are read without waiting, so that no client has to be served.
struct Nobody;

impl Link for Nobody {
    fn call(
        &mut self,
        _: hal_protocol::Request,
    ) -> Result<hal_protocol::Reply, hal_protocol::Failure> {
        Ok(hal_protocol::Reply::Done)
    }
}

#[cfg(test)]
mod tests {
    use super::{Error, Line, lines, without_comment, words};

    fn shown(text: &[u8]) -> String {
        let mut out = String::new();
        for line in lines(text) {
            let text = line.text.map_or_else(|e| format!("! {e}"), |t| format!("{t:?}"));
            out.push_str(&format!(
                "{}{} {text}\n",
                line.number,
                if line.dos { " dos" } else { "" }
            ));
        }
        out
    }

    #[test]
    fn physical_lines_become_lines() {
        for (text, want) in [
            ("a\nb", "1 \"a\"\n2 \"b\"\n"),
            ("a\\\n,b\n", "2 \"a,b\"\n"),
            ("a\\ \nb\n", "1 \"a\\\\ \"\n2 \"b\"\n"),
            ("# c\\\nswallowed\nd\n", "2 \"# cswallowed\"\n3 \"d\"\n"),
            ("\\\nd\n", "2 \"d\"\n"),
            ("a\nb\\", "1 \"a\"\n"),
            ("a\nb\\\n", "1 \"a\"\n"),
            ("a\r\nb\r\n", "1 dos \"a\"\n2 \"b\"\n"),
            ("a\\\r\nb\r\n", "2 dos \"ab\"\n"),
            ("a\rb\nc\n", "1 ! File contains embedded carriage returns.\n2 \"c\"\n"),
            ("\n\n", "1 \"\"\n2 \"\"\n"),
            ("\u{feff}a\nb\n", "1 \"a\"\n2 \"b\"\n"),
            ("", ""),
        ] {
            assert_eq!(shown(text.as_bytes()), want, "{text:?}");
        }
    }

    #[test]
    fn a_long_line_is_refused_and_the_next_has_its_own_number() {
        for (length, first) in [(1023, "ok"), (1024, "!"), (2046, "!"), (2400, "!")] {
            let text = format!("{}\nend\nlast", "x".repeat(length));
            let lines = lines(text.as_bytes());
            let shown = |l: &Line| match &l.text {
                Ok(text) if text.len() == length => format!("{} ok", l.number),
                Ok(text) => format!("{} {text}", l.number),
                Err(e) => format!("{} ! {e}", l.number),
            };
            let lines: Vec<String> = lines.iter().map(shown).collect();
            assert_eq!(lines.len(), 3, "{lines:?}");
            assert!(lines[0].starts_with(&format!("1 {first}")), "{lines:?}");
            assert_eq!(lines[1..], ["2 end", "3 last"]);
        }
        let text = "x".repeat(1023);
        assert_eq!(lines(text.as_bytes())[0].text.as_ref().unwrap().len(), 1023);
        let joined = format!("{}\\\n{}\n", "y".repeat(900), "z".repeat(900));
        assert_eq!(lines(joined.as_bytes())[0].text.as_ref().unwrap().len(), 1800);
    }

    #[test]
    fn comments_go_unless_quoted() {
        for (line, want) in [
            ("print x # c", Ok("print x ")),
            ("print \"a#b\" # c", Ok("print \"a#b\" ")),
            ("print 'a#b'#c", Ok("print 'a#b'")),
            ("# all", Ok("")),
            ("x#y", Ok("x")),
            ("print \"abc", Err(Error::UnterminatedQuote)),
            ("print 'a\"b", Err(Error::UnterminatedQuote)),
            ("# it's fine", Ok("")),
            ("", Ok("")),
        ] {
            assert_eq!(without_comment(line), want, "{line}");
        }
    }

    #[test]
    fn blanks_split_words_and_quotes_stay() {
        for (line, want) in [
            ("print \"abc#def\"", &["print", "\"abc#def\""][..]),
            ("ab\"c d\"e", &["ab\"c d\"e"]),
            ("a'b c'd e", &["a'b c'd", "e"]),
            ("'a\"b' c", &["'a\"b'", "c"]),
            (" \t a\x0bb\x0cc  ", &["a", "b", "c"]),
            ("\"\" ''", &["\"\"", "''"]),
            ("", &[]),
            ("   ", &[]),
        ] {
            assert_eq!(words(line).unwrap(), want, "{line:?}");
        }
        assert_eq!(words("a \"b"), Err(Error::UnterminatedQuote));
        assert_eq!(words(&"a ".repeat(32)).unwrap().len(), 32);
        assert_eq!(words(&"a ".repeat(33)), Err(Error::TooManyTokens));
    }
}
