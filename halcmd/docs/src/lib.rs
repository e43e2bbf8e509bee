//! The manual. Its chapters are the Markdown of `halcmd/book`; the build makes pages of them, which the panel serves and
//! `ferrule docs` writes into a folder.
#![forbid(unsafe_code)]

mod search;

use flate2::read::GzDecoder;
use std::io::{self, Read as _};

pub use search::{Section, search, sections};

/// Files of the manual as pages: names and gzipped contents. The first page is `index.html`.
pub const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/files.rs"));

/// Chapters in their order.
pub const CHAPTERS: &[Chapter] = include!(concat!(env!("OUT_DIR"), "/chapters.rs"));

/// Chapter of the manual.
#[derive(Debug)]
pub struct Chapter {
    /// Name of its file in `halcmd/book/src`.
    pub file: &'static str,
    /// Title in the list of chapters.
    pub title: &'static str,
    /// Heading above it in the list of chapters.
    pub part: &'static str,
    gzipped: &'static [u8],
}

impl Chapter {
    /// Returns the chapter in Markdown, with the parts that it takes from other files.
    ///
    /// # Errors
    /// The program is damaged.
    pub fn text(&self) -> io::Result<String> {
        let mut text = String::new();
        GzDecoder::new(self.gzipped).read_to_string(&mut text)?;
        Ok(text)
    }
}

/// Returns a file of the manual, uncompressed.
///
/// # Errors
/// The program is damaged.
pub fn content(gzipped: &[u8]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    GzDecoder::new(gzipped).read_to_end(&mut bytes)?;
    Ok(bytes)
}
