//! Fast search for O-words without running the lines between.

use std::collections::BTreeMap;

use crate::{
    error::Problem,
    state::Cursor,
    text::{
        Input, clean,
        oword::{self, Label},
    },
};

/// A definition that is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found<'a> {
    /// `o<label> sub`
    Sub(&'a str),
    /// `o<label>` alone.
    Part(&'a str),
}

/// The definitions of a file.
#[derive(Default)]
pub struct Index {
    subs: BTreeMap<Box<str>, Cursor>,
    parts: BTreeMap<Box<str>, Cursor>,
}

impl Index {
    /// Reads the definitions of a text; the first one of a label counts. Of a text that begins with a percent sign, the
    /// next one is the end. `read` reads a line.
    ///
    /// # Errors
    /// A line cannot be read.
    pub fn of(
        mut read: impl FnMut(Cursor, &mut Vec<u8>) -> Result<Option<Cursor>, Problem>,
    ) -> Result<Self, Problem> {
        let mut out = Self::default();
        let (mut raw, mut cleaned) = (Vec::new(), Vec::new());
        let mut cursor = Cursor::default();
        let mut begins_with_percent = None;
        while let Some(next) = read(cursor, &mut raw)? {
            cursor = next;
            let text = raw.trim_ascii();
            match begins_with_percent {
                None if text.is_empty() => {}
                None => begins_with_percent = Some(text == b"%"),
                Some(true) if text == b"%" => break,
                Some(_) => {}
            }
            let Some((Label::Name(label), rest)) = o_word(&raw, &mut cleaned) else { continue };
            match oword::keyword(rest) {
                Some("sub") => {
                    out.subs.entry(label).or_insert(next);
                }
                None => {
                    out.parts.entry(label).or_insert(next);
                }
                Some(_) => {}
            }
        }
        Ok(out)
    }

    /// Returns the place behind the definition.
    pub fn find(&self, wanted: Found<'_>) -> Option<Cursor> {
        match wanted {
            Found::Sub(label) => self.subs.get(label).copied(),
            Found::Part(label) => self.parts.get(label).copied(),
        }
    }
}

/// Returns the label of a line with an O-word, and the cleaned text behind it.
pub(super) fn o_word<'a>(raw: &[u8], cleaned: &'a mut Vec<u8>) -> Option<(Label, Input<'a>)> {
    // Most lines have no O-word: look before cleaning.
    let first = raw.iter().find(|b| !b.is_ascii_whitespace())?;
    if !matches!(first, b'o' | b'O' | b'n' | b'N' | b'/') {
        return None;
    }
    clean::clean(raw, cleaned).ok()?;
    let mut rest: &[u8] = cleaned;
    if let [b'/', after @ ..] = rest {
        rest = after;
    }
    if let [b'n', after @ ..] = rest {
        let digits = after.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
        rest = after.get(digits..).unwrap_or_default();
    }
    let rest = rest.strip_prefix(b"o")?;
    let (rest, label) = oword::label(rest).ok()?;
    Some((label, rest))
}
