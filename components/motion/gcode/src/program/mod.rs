//! Programs: files and the lines in them, flow control, saved modal state.

pub mod flow;
pub mod save;
mod scan;

use std::collections::BTreeMap;

use crate::{
    environment::{Environment, Text},
    state::Cursor,
};
pub use scan::{Found, Index};

/// The files that were opened, with their subroutines. Not a part of the state: it is made again when it is needed.
#[derive(Default)]
pub struct Sources {
    texts: BTreeMap<Box<str>, Text>,
    indices: BTreeMap<Box<str>, Index>,
}

impl Sources {
    /// Returns the text of a file.
    pub fn text(&mut self, name: &str, environment: &dyn Environment) -> Option<Text> {
        if let Some(text) = self.texts.get(name) {
            return Some(Text::clone(text));
        }
        let text = environment.open(name)?;
        self.texts.insert(name.into(), Text::clone(&text));
        Some(text)
    }

    /// Sets the text of a file.
    pub fn put(&mut self, name: &str, text: Text) {
        self.indices.remove(name);
        self.texts.insert(name.into(), text);
    }

    /// Returns the place behind the line that defines a subroutine or part.
    pub fn find(
        &mut self,
        file: &str,
        wanted: Found<'_>,
        environment: &dyn Environment,
    ) -> Option<Cursor> {
        if !self.indices.contains_key(file) {
            let text = self.text(file, environment)?;
            self.indices.insert(file.into(), Index::of((*text).as_ref()));
        }
        self.indices.get(file)?.find(wanted)
    }
}

/// Returns the line at `cursor` without its end, and the cursor behind it.
pub fn line_at(text: &[u8], cursor: Cursor) -> Option<(&[u8], Cursor)> {
    let from = usize::try_from(cursor.offset).ok()?;
    let rest = text.get(from..).filter(|r| !r.is_empty())?;
    let length = rest.iter().position(|b| *b == b'\n');
    let line = length.map_or(rest, |l| rest.get(..l).unwrap_or_default());
    let taken = length.map_or(rest.len(), |l| l + 1);
    let next = Cursor {
        offset: cursor.offset.saturating_add(taken as u64),
        line: cursor.line.saturating_add(1),
    };
    Some((line, next))
}
