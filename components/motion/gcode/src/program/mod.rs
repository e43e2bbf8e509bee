//! Programs: files and the lines in them, flow control, saved modal state.

pub mod flow;
mod locate;
mod pages;
mod part;
pub mod save;
mod scan;

use std::{collections::BTreeMap, sync::Arc};

use crate::{
    environment::{Environment, Text},
    error::Problem,
    state::Cursor,
};
use pages::Pages;
pub use scan::{Found, Index};

/// The files that were opened, with their subroutines. Not a part of the state: it is made again when it is needed.
#[derive(Default)]
pub struct Sources {
    files: BTreeMap<Box<str>, Pages>,
    indices: BTreeMap<Box<str>, Index>,
}

impl Sources {
    /// Reads the line of a file at `cursor` into `line`, and returns the cursor behind it; `None` at the end. At most
    /// `longest` bytes and one more are read.
    ///
    /// # Errors
    /// There is no such file, or it cannot be read.
    pub fn line(
        &mut self,
        file: &str,
        cursor: Cursor,
        longest: usize,
        environment: &dyn Environment,
        line: &mut Vec<u8>,
    ) -> Result<Option<Cursor>, Problem> {
        let pages = match self.files.get_mut(file) {
            Some(pages) => pages,
            None => {
                let none = || match environment.refusal(file) {
                    Some(reason) => Problem::FileUnread { name: file.into(), reason },
                    None => Problem::NoFile { name: file.into() },
                };
                let text = environment.open(file).ok_or_else(none)?;
                self.files.entry(file.into()).or_insert(Pages::new(text))
            }
        };
        let read = pages.line(cursor, longest, line);
        read.map_err(|reason| Problem::FileUnread { name: file.into(), reason })
    }

    /// Sets the text of a file.
    pub fn put(&mut self, name: &str, text: Text) {
        self.indices.remove(name);
        self.files.insert(name.into(), Pages::new(text));
    }

    /// Returns the place behind the line that defines a subroutine or part; `None` if there is no such file either.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn find(
        &mut self,
        file: &str,
        wanted: Found<'_>,
        longest: usize,
        environment: &dyn Environment,
    ) -> Result<Option<Cursor>, Problem> {
        if !self.indices.contains_key(file) {
            let read =
                |cursor, line: &mut Vec<u8>| self.line(file, cursor, longest, environment, line);
            match Index::of(read) {
                Ok(index) => self.indices.insert(file.into(), index),
                Err(Problem::NoFile { .. }) => return Ok(None),
                Err(problem) => return Err(problem),
            };
        }
        Ok(self.indices.get(file).and_then(|index| index.find(wanted)))
    }
}

/// Tells whether a text begins with a percent sign and has another one, which is its end.
pub fn has_percent_signs(text: &Text, longest: usize) -> bool {
    let mut pages = Pages::new(Arc::clone(text));
    let (mut cursor, mut line, mut begins) = (Cursor::default(), Vec::new(), false);
    while let Ok(Some(next)) = pages.line(cursor, longest, &mut line) {
        cursor = next;
        match line.trim_ascii() {
            b"%" if begins => return true,
            b"%" => begins = true,
            b"" => {}
            _ if begins => {}
            _ => return false,
        }
    }
    false
}

/// Returns a line of a text by its number, from 1 on, or at most its first `longest` bytes and one more.
pub fn numbered_line(text: &Text, number: u64, longest: usize) -> Option<Vec<u8>> {
    let mut pages = Pages::new(Arc::clone(text));
    let (mut cursor, mut line) = (Cursor::default(), Vec::new());
    for _ in 0..number {
        cursor = pages.line(cursor, longest, &mut line).ok()??;
    }
    (number > 0).then_some(line)
}
