//! Changes of a line: values replaced, words inserted or removed, the rest byte for byte.

use super::words::{Word, Words};

/// Numbers as the result has them: four decimals in millimetres, five in inches, never `-0`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Digits(pub(super) bool);

impl Digits {
    /// Returns the text of a length in millimetres, and the length that the text says.
    pub(super) fn write(self, mm: f64) -> (String, f64) {
        let (unit, digits) = if self.0 { (25.4, 5) } else { (1.0, 4) };
        let mut text = format!("{:.digits$}", mm / unit);
        if text.starts_with('-') && text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.')) {
            text.remove(0);
        }
        let said = text.parse::<f64>().unwrap_or(0.0) * unit;
        (text, said)
    }
}

/// Changes of one line.
#[derive(Default)]
pub(super) struct Edits(Vec<(usize, usize, String)>);

impl Edits {
    /// Replaces the value of a word.
    pub(super) fn value(&mut self, word: &Word, text: String) {
        self.0.push((word.from, word.to, text));
    }

    /// Replaces the last digit of the value of a word, such as the 2 of `G02`.
    pub(super) fn last_digit(&mut self, raw: &[u8], word: &Word, digit: char) {
        let value = raw.get(word.from..word.to).unwrap_or_default();
        let whole = value.iter().position(|b| *b == b'.').unwrap_or(value.len());
        let at = value.iter().take(whole).rposition(u8::is_ascii_digit).unwrap_or(0);
        self.0.push((word.from + at, word.from + at + 1, digit.to_string()));
    }

    /// Replaces a word by others.
    pub(super) fn replace(&mut self, word: &Word, text: String) {
        self.0.push((word.at, word.to, text));
    }

    /// Removes a word and the blanks before it.
    pub(super) fn remove(&mut self, raw: &[u8], word: &Word) {
        let before = raw.get(..word.at).unwrap_or_default();
        let blanks = before.iter().rev().take_while(|b| matches!(b, b' ' | b'\t')).count();
        self.0.push((word.at - blanks, word.to, String::new()));
    }

    /// Inserts a word before another one, with a blank between them if the line has one there.
    pub(super) fn before(&mut self, raw: &[u8], word: &Word, text: &str) {
        let blank = if is_loose(raw, word) { " " } else { "" };
        self.0.push((word.at, word.at, format!("{text}{blank}")));
    }

    /// Inserts a word behind another one, with a blank between them if the line has one before that.
    pub(super) fn behind(&mut self, raw: &[u8], word: &Word, text: &str) {
        let blank = if is_loose(raw, word) { " " } else { "" };
        self.0.push((word.to, word.to, format!("{blank}{text}")));
    }

    /// Returns the line with all changes.
    pub(super) fn apply(mut self, raw: &[u8]) -> Vec<u8> {
        self.0.sort_by_key(|e| (e.0, e.1));
        let mut out = Vec::with_capacity(raw.len() + 16);
        let mut at = 0;
        for (from, to, text) in &self.0 {
            out.extend(raw.get(at..*from).unwrap_or_default());
            out.extend(text.as_bytes());
            at = at.max(*to);
        }
        out.extend(raw.get(at..).unwrap_or_default());
        out
    }
}

/// Returns whether a word stands after a blank or at the begin of the line.
fn is_loose(raw: &[u8], word: &Word) -> bool {
    word.at == 0 || raw.get(word.at - 1).is_some_and(u8::is_ascii_whitespace)
}

/// Returns a letter as the line writes its words: in capitals, or not.
pub(super) fn letter(raw: &[u8], words: &Words, letter: u8) -> char {
    let first = words.list.first().and_then(|w| raw.get(w.at));
    let is_small = first.is_some_and(u8::is_ascii_lowercase);
    char::from(if is_small { letter.to_ascii_lowercase() } else { letter.to_ascii_uppercase() })
}
