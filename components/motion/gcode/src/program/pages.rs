//! Lines of a file that is read in pages, so that memory does not grow with the file.

use crate::{environment::Text, state::Cursor};

/// Bytes of a page.
const PAGE: usize = 16 << 10;

/// Pages that are kept of a file: loops and calls go to and fro between a few places.
const KEPT: usize = 4;

/// The pages of a file that were used last.
pub(super) struct Pages {
    text: Text,
    pages: Vec<Page>,
    /// Number of uses so far.
    uses: u64,
}

struct Page {
    number: u64,
    bytes: Vec<u8>,
    last_use: u64,
}

impl Pages {
    /// Returns the pages of a text, none of them read yet.
    pub(super) fn new(text: Text) -> Self {
        Self { text, pages: Vec::new(), uses: 0 }
    }

    /// Reads the line at `cursor` without its end into `line`, and returns the cursor behind it. Of a longer line, the
    /// first `longest` bytes and one more are read.
    ///
    /// # Errors
    /// The file cannot be read; the reason.
    pub(super) fn line(
        &mut self,
        cursor: Cursor,
        longest: usize,
        line: &mut Vec<u8>,
    ) -> Result<Option<Cursor>, Box<str>> {
        line.clear();
        let mut offset = cursor.offset;
        loop {
            let bytes = self.page(offset / PAGE as u64)?;
            let from = usize::try_from(offset % PAGE as u64).unwrap_or(PAGE);
            let rest = bytes.get(from..).unwrap_or_default();
            if rest.is_empty() {
                if offset == cursor.offset {
                    return Ok(None);
                }
                break;
            }
            let length = rest.iter().position(|b| *b == b'\n');
            let part = length.map_or(rest, |l| rest.get(..l).unwrap_or_default());
            let room = longest.saturating_add(1).saturating_sub(line.len());
            line.extend_from_slice(part.get(..room).unwrap_or(part));
            offset = offset.saturating_add(part.len() as u64);
            if length.is_some() {
                offset = offset.saturating_add(1);
                break;
            }
        }
        Ok(Some(Cursor { offset, line: cursor.line.saturating_add(1) }))
    }

    /// Returns the bytes of a page; the page behind the end has none.
    fn page(&mut self, number: u64) -> Result<&[u8], Box<str>> {
        self.uses += 1;
        let kept = self.pages.iter().position(|p| p.number == number);
        let index = match kept {
            Some(index) => index,
            None => {
                let mut bytes = self.oldest();
                bytes.resize(PAGE, 0);
                let mut filled = 0;
                let start = number.saturating_mul(PAGE as u64);
                while let Some(room) = bytes.get_mut(filled..).filter(|r| !r.is_empty()) {
                    let count = self.text.read_at(start + filled as u64, room)?;
                    if count == 0 {
                        break;
                    }
                    filled += count;
                }
                bytes.truncate(filled);
                self.pages.push(Page { number, bytes, last_use: 0 });
                self.pages.len() - 1
            }
        };
        let uses = self.uses;
        Ok(self.pages.get_mut(index).map_or(&[], |page| {
            page.last_use = uses;
            &page.bytes
        }))
    }

    /// Returns the memory of the page to be replaced, or new memory.
    fn oldest(&mut self) -> Vec<u8> {
        let uses = self.pages.iter().enumerate().map(|(k, p)| (p.last_use, k));
        match uses.min() {
            Some((_, k)) if self.pages.len() >= KEPT => self.pages.swap_remove(k).bytes,
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Lines of every length around the borders of pages are those of the text.
    #[test]
    fn lines_across_pages_are_whole() {
        let lines: Vec<Vec<u8>> =
            (0..4000_usize).map(|k| vec![[b'a', b'b', b'c'][k % 3]; k % 97]).collect();
        let text = lines.join(&b'\n');
        assert!(text.len() > 10 * PAGE);
        let mut pages = Pages::new(Arc::new(text));
        let (mut cursor, mut line, mut starts) = (Cursor::default(), Vec::new(), Vec::new());
        for wanted in &lines {
            starts.push(cursor);
            cursor = pages.line(cursor, 4096, &mut line).unwrap().unwrap();
            assert_eq!(line, *wanted);
        }
        assert_eq!(pages.line(cursor, 4096, &mut line), Ok(None));
        assert_eq!(pages.pages.len(), KEPT);
        // Backward too.
        for (wanted, start) in lines.iter().zip(starts).rev() {
            pages.line(start, 4096, &mut line).unwrap().unwrap();
            assert_eq!(line, *wanted);
        }
    }

    #[test]
    fn a_long_line_takes_no_memory() {
        let mut text = vec![b'x'; 10 * PAGE];
        text.extend(b"\nnext");
        let mut pages = Pages::new(Arc::new(text));
        let mut line = Vec::new();
        let next = pages.line(Cursor::default(), 100, &mut line).unwrap().unwrap();
        assert_eq!(line.len(), 101);
        pages.line(next, 100, &mut line).unwrap();
        assert_eq!(line, b"next");
    }
}
