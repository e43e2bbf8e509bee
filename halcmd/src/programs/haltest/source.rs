//! The text of a test: line numbers of its parts, and errors in it.

use super::{
    file::{Text, Values},
    instant::Instant,
    outcome::{Complaint, Spot},
    test::{Entry, Named},
};
use crate::{language::hint::nearest, nanoseconds};
use core::ops::Range;

/// Form of a time.
pub(super) const TIMES: &str = "a time is a number and ns, us, ms or s, such as 20ms";

/// Names that serde gives to kinds of values, and their names in our messages.
const KINDS: &[(&str, &str)] = &[
    ("a string", "a text in quotes"),
    ("string", "the text"),
    ("floating point", "the number"),
    ("integer", "the number"),
    ("boolean", "the value"),
    ("a sequence", "a list in [ ]"),
    ("sequence", "a list"),
    ("a map", "a table"),
    ("map", "a table"),
    ("f64", "a number"),
    ("u32", "a whole number"),
    ("u64", "a whole number"),
    ("u8", "a whole number from 0 to 255"),
];

/// The text of a file.
pub(super) struct Source<'t> {
    shown: &'t str,
    text: &'t str,
}

impl<'t> Source<'t> {
    pub(super) const fn new(shown: &'t str, text: &'t str) -> Self {
        Self { shown, text }
    }

    /// Returns the name of the file as it was given.
    pub(super) const fn shown(&self) -> &'t str {
        self.shown
    }

    /// Returns the file and line of a part of the text.
    pub(super) fn spot(&self, span: &Range<usize>) -> Spot {
        let before = self.text.bytes().take(span.start);
        let lines = before.filter(|b| *b == b'\n').count();
        Spot { file: self.shown.to_owned(), line: u32::try_from(lines + 1).unwrap_or(u32::MAX) }
    }

    pub(super) fn named(&self, text: &Text) -> Named {
        Named { spot: self.spot(&text.span()), name: text.get_ref().clone() }
    }

    pub(super) fn all_named(&self, texts: &[Text]) -> Vec<Named> {
        texts.iter().map(|t| self.named(t)).collect()
    }

    /// Returns lines of the HAL language; the location is that of the first line.
    pub(super) fn lines(&self, text: &Text) -> Named {
        let mut named = self.named(text);
        let rest = self.text.get(text.span().start..).unwrap_or_default();
        let quotes = ["\"\"\"\n", "'''\n", "\"\"\"\r\n", "'''\r\n"];
        named.spot.line += u32::from(quotes.iter().any(|q| rest.starts_with(q)));
        named
    }

    /// Returns names and values in the order in which the file has them.
    pub(super) fn entries(&self, values: Values) -> Vec<Entry> {
        let mut all: Vec<_> = values.into_iter().collect();
        all.sort_by_key(|(name, _)| name.span().start);
        let entry = |(name, value): (Text, toml::Spanned<toml::Value>)| Entry {
            spot: self.spot(&name.span()),
            name: name.into_inner(),
            value: value.into_inner(),
        };
        all.into_iter().map(entry).collect()
    }

    /// Parses a duration.
    pub(super) fn time(&self, text: &Text) -> Result<u64, Complaint> {
        nanoseconds(text.get_ref()).map_err(|_| {
            let what = format!("'{}' is not a time", text.get_ref());
            Complaint::new(&self.spot(&text.span()), what).with(TIMES)
        })
    }

    /// Parses a moment. Returns `or` if there is none.
    pub(super) fn instant(&self, text: Option<&Text>, or: Instant) -> Result<Instant, Complaint> {
        text.map_or(Ok(or), |t| Instant::parse(t.get_ref(), &self.spot(&t.span())))
    }

    /// Returns the error for a text that is not a test.
    pub(super) fn misread(&self, error: &toml::de::Error) -> Complaint {
        let spot = self.spot(&error.span().unwrap_or(0..0));
        let message = error.message().trim_end();
        let words: Vec<&str> = message.split('`').collect();
        match words.as_slice() {
            ["unknown field ", word, _, keys @ ..] => {
                let keys: Vec<&str> = keys.iter().step_by(2).copied().collect();
                let complaint = Complaint::new(&spot, format!("unknown key '{word}'"));
                match nearest(word, keys.iter().copied()) {
                    Some(near) => complaint.near(Some(near)),
                    None => complaint.with(format!("the keys here are {}", keys.join(", "))),
                }
            }
            ["missing field ", word, ..] => Complaint::new(&spot, format!("no key '{word}'")),
            _ => match message
                .strip_prefix("invalid type: ")
                .and_then(|m| m.split_once(", expected "))
            {
                Some((found, wanted)) => {
                    let found = KINDS.iter().find_map(|(kind, name)| {
                        found.strip_prefix(kind).map(|rest| format!("{name}{rest}"))
                    });
                    let kind = KINDS.iter().find(|(kind, _)| *kind == wanted);
                    let kind = kind.map_or(wanted, |(_, name)| name);
                    let found = found.unwrap_or_else(|| message.to_owned()).replace('`', "");
                    Complaint::new(&spot, format!("expected {kind}, found {found}"))
                }
                None => Complaint::new(&spot, message.replace('\n', "; ")),
            },
        }
    }
}
