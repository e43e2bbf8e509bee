//! Programs: files, places in them, calls and open loops.

pub mod flow;
pub mod save;
mod scan;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    environment::{Environment, Text},
    error::Place,
    interpret::remap::Remapped,
    parameters::Names,
};
pub use scan::{Found, Index};

/// A place between two lines of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cursor {
    /// The bytes before it.
    pub offset: u64,
    /// The lines before it.
    pub line: u32,
}

/// A loop or condition in progress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Open {
    /// The label.
    pub label: Box<str>,
    /// The kind.
    pub kind: OpenKind,
}

/// The kind of a loop or condition, with the place to continue at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum OpenKind {
    /// `while` at this place.
    While(Cursor),
    /// `do`, whose first line is at this place.
    Do(Cursor),
    /// `repeat`, whose first line is at this place, with the passes left.
    Repeat(Cursor, u32),
    /// `if`
    If,
}

/// The kind of a level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LevelKind {
    /// The main program; `percent` tells that a percent sign ends it.
    Main {
        /// A percent sign ends it.
        percent: bool,
    },
    /// A line of MDI.
    Mdi,
    /// A subroutine.
    Sub,
    /// A part that M98 called, with its begin and the passes left.
    Part(Cursor, u32),
}

/// A level of the program: the main program or a call.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// The file.
    pub file: Box<str>,
    /// The next line.
    pub cursor: Cursor,
    /// The kind.
    pub kind: LevelKind,
    /// The label of the subroutine.
    pub label: Box<str>,
    /// Local named parameters.
    pub locals: Names,
    /// Parameters 1 to 30 of the caller.
    pub saved: Vec<f64>,
    /// Loops and conditions in progress.
    pub open: Vec<Open>,
    /// The modal state that M70 or M73 saved.
    pub modal: Option<Box<save::Saved>>,
    /// The modal state returns at the end of the level (M73).
    pub restores: bool,
    /// The pass of the innermost loop, counted over the level.
    pub pass: u64,
    /// The block whose remapped code runs in this level.
    pub remapped: Option<Box<Remapped>>,
}

impl Level {
    /// Returns a level that begins at `cursor`.
    pub fn new(file: Box<str>, cursor: Cursor, kind: LevelKind) -> Self {
        Self {
            file,
            cursor,
            kind,
            label: Box::default(),
            locals: Names::new(),
            saved: Vec::new(),
            open: Vec::new(),
            modal: None,
            restores: false,
            pass: 0,
            remapped: None,
        }
    }

    /// Returns the place of the line that was read last.
    pub fn place(&self) -> Place {
        Place { file: self.file.clone(), line: self.cursor.line, column: 0 }
    }
}

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
