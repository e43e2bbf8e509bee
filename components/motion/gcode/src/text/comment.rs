//! Comments with a meaning: `MSG`, `DEBUG`, `PRINT`, `LOG`, `ABORT`, and the files of logs and probes.
//!
//! The last comment in brackets of a line counts. What else stands on the line, before it or behind it, changes nothing.

use crate::{parameters::format_value, text::evaluate::Values};

/// The meaning of a comment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A remark.
    Plain,
    /// A message for the operator, as it is written.
    Message,
    /// A message with values of parameters.
    Debug,
    /// A line for the terminal with values of parameters.
    Print,
    /// A line for the log file with values of parameters.
    Log,
    /// A log file opens.
    LogOpen,
    /// A log file opens at its end.
    LogAppend,
    /// The log file closes.
    LogClose,
    /// A file for probe results opens.
    ProbeOpen,
    /// The file for probe results closes.
    ProbeClose,
    /// The program ends with an error and this message.
    Abort,
    /// Text in Python, which is refused.
    Python,
}

/// The comments with a meaning: the word that begins them, and whether a text follows a comma.
pub const KINDS: [(&str, Kind); 13] = [
    ("msg,", Kind::Message),
    ("debug,", Kind::Debug),
    ("print,", Kind::Print),
    ("logopen,", Kind::LogOpen),
    ("logappend,", Kind::LogAppend),
    ("logclose", Kind::LogClose),
    ("log,", Kind::Log),
    ("probeopen", Kind::ProbeOpen),
    ("probeclose", Kind::ProbeClose),
    ("abort,", Kind::Abort),
    ("py,", Kind::Python),
    ("pyrun,", Kind::Python),
    ("pyreload", Kind::Python),
];

/// Returns the meaning of the comment `text` (without its brackets) and what follows the word.
pub fn classify(text: &str) -> (Kind, &str) {
    let text = text.trim_start();
    for (word, kind) in KINDS {
        let start = text.get(..word.len());
        if start.is_some_and(|s| s.eq_ignore_ascii_case(word)) {
            return (kind, text.get(word.len()..).unwrap_or_default());
        }
    }
    (Kind::Plain, text)
}

/// Returns `text` with `#n` and `#<name>` replaced by their values; `%d`, `%f` and `%.nf` set the format.
pub fn expand(text: &str, values: &dyn Values) -> String {
    let mut out = String::new();
    let mut rest = text;
    let mut digits = 6;
    while let Some(first) = rest.chars().next() {
        if let Some((precision, after)) = format_mark(rest) {
            digits = precision;
            rest = after;
        } else if let Some((value, after)) = parameter(rest, values) {
            match value {
                Some(v) => out.push_str(&format_value(v, digits)),
                None => out.push_str("######"),
            }
            rest = after;
        } else {
            out.push(first);
            rest = rest.get(first.len_utf8()..).unwrap_or_default();
        }
    }
    out
}

fn format_mark(text: &str) -> Option<(usize, &str)> {
    let mark = text.strip_prefix('%')?;
    if let Some(rest) = mark.strip_prefix('d') {
        return Some((0, rest));
    }
    if let Some(rest) = mark.strip_prefix('f') {
        return Some((4, rest));
    }
    let rest = mark.strip_prefix('.')?;
    let digit = rest.chars().next()?.to_digit(10)?;
    let rest = rest.get(1..)?.strip_prefix('f')?;
    Some((usize::try_from(digit).ok()?, rest))
}

fn parameter<'a>(text: &'a str, values: &dyn Values) -> Option<(Option<f64>, &'a str)> {
    let rest = text.strip_prefix('#')?;
    if let Some(inner) = rest.strip_prefix('<') {
        let end = inner.find('>')?;
        let name: String = inner.get(..end)?.chars().filter(|c| !c.is_whitespace()).collect();
        let lower = name.to_ascii_lowercase();
        let value = values.named(&lower).ok();
        return Some((value, inner.get(end + 1..)?));
    }
    let length = rest.bytes().take_while(u8::is_ascii_digit).count();
    let index: i32 = rest.get(..length)?.parse().ok()?;
    Some((values.numbered(index).ok(), rest.get(length..)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_known_with_capitals() {
        assert_eq!(classify("MSG, hello"), (Kind::Message, " hello"));
        assert_eq!(classify(" dEbug,x"), (Kind::Debug, "x"));
        assert_eq!(classify("msg ,x"), (Kind::Plain, "msg ,x"));
        assert_eq!(classify("message"), (Kind::Plain, "message"));
        assert_eq!(classify("logclose"), (Kind::LogClose, ""));
    }
}
