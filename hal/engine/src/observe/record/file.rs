//! A file that contains only whole records at any moment.

use crate::ends::record;
use hal_output::Growing;
use std::{
    collections::VecDeque,
    io::{Error, ErrorKind, Result, Write},
};

/// Number of bytes of whole records that are written at once, exceeded by at most one record. A
/// refused write is undone.
const PIECE: usize = 1 << 13;

/// The file of a recording. Records are collected here; only whole ones reach the file.
#[derive(Debug)]
pub(crate) struct WholeFile {
    /// None once the file is finished.
    file: Option<Growing>,
    buffer: Vec<u8>,
    /// Number of bytes of `buffer` that are whole records.
    whole: usize,
    /// Ends of pieces of whole records in `buffer`, and the time of the last record of each in
    /// nanoseconds.
    pieces: VecDeque<(usize, Option<i64>)>,
    /// Number of bytes in the file, and the time of its last record in nanoseconds.
    written: u64,
    kept_to: Option<i64>,
}

impl WholeFile {
    /// Wraps a file that was just created.
    pub(crate) fn new(file: Growing) -> Self {
        record(0, 0);
        let (buffer, pieces) = (Vec::new(), VecDeque::new());
        Self { file: Some(file), buffer, whole: 0, pieces, written: 0, kept_to: None }
    }

    /// Marks everything written so far as whole records, the last one with time `at`.
    pub(crate) fn end_record(&mut self, at: Option<i64>) {
        self.whole = self.buffer.len();
        let mut ends = self.pieces.iter().rev().map(|p| p.0);
        let (last, before) = (ends.next(), ends.next().unwrap_or(0));
        if last.is_some_and(|last| last - before < PIECE) {
            self.pieces.pop_back();
        }
        self.pieces.push_back((self.whole, at));
    }

    /// Returns the number of bytes of whole records that are not in the file yet.
    pub(crate) const fn waiting(&self) -> usize {
        self.whole
    }

    /// Returns the number of bytes in the file, and the time of its last record in nanoseconds.
    pub(crate) const fn kept(&self) -> (u64, Option<i64>) {
        (self.written, self.kept_to)
    }

    /// Writes the whole records to the file.
    ///
    /// # Errors
    /// The system refuses. The file then ends at the last whole record that it took before.
    pub(crate) fn put(&mut self) -> Result<()> {
        let Some(file) = &mut self.file else { return Err(ended()) };
        let mut from = 0;
        while let Some((to, at)) = self.pieces.pop_front() {
            let piece = self.buffer.get(from..to).unwrap_or_default();
            // If the process is killed while it writes, the watcher truncates the file.
            record(self.written, self.written + piece.len() as u64);
            let appended = file.append(piece);
            self.written = file.bytes();
            record(self.written, self.written);
            appended?;
            (self.kept_to, from) = (at, to);
        }
        self.buffer.drain(..from);
        self.whole = 0;
        Ok(())
    }

    /// Writes the whole records and closes the file.
    ///
    /// # Errors
    /// The system refuses. The file then ends at a whole record.
    pub(crate) fn finish(&mut self) -> Result<()> {
        self.put()?;
        self.file.take().map_or_else(|| Err(ended()), Growing::finish)
    }
}

fn ended() -> Error {
    Error::new(ErrorKind::BrokenPipe, "the file has ended")
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.buffer.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        self.put()
    }
}

#[cfg(test)]
mod tests {
    use super::WholeFile;
    use hal_output::Growing;
    use std::{fs, io::Write};

    #[test]
    fn only_whole_records_reach_the_file() {
        let path = std::env::temp_dir().join(format!("hal-whole-{}", std::process::id()));
        fs::write(&path, "good").unwrap();
        let mut file = WholeFile::new(Growing::create(&path).unwrap());
        let inside = || fs::read_to_string(&path).unwrap();
        file.write_all(b"#1\n1!\n").unwrap();
        assert_eq!((inside().as_str(), file.waiting()), ("good", 0));
        file.end_record(Some(1));
        file.write_all(b"#2\n0").unwrap();
        assert_eq!((file.waiting(), file.kept()), (6, (0, None)));
        file.put().unwrap();
        assert_eq!((inside().as_str(), file.waiting()), ("#1\n1!\n", 0));
        assert_eq!(file.kept(), (6, Some(1)));
        file.put().unwrap();
        assert_eq!(file.kept(), (6, Some(1)));
        file.write_all(b"!\n").unwrap();
        file.end_record(Some(2));
        file.finish().unwrap();
        assert_eq!((inside().as_str(), file.kept()), ("#1\n1!\n#2\n0!\n", (12, Some(2))));
        assert!(file.finish().is_err());
        fs::remove_file(&path).unwrap();
    }

    #[test]
    fn pieces_are_whole_records_and_not_much_longer_than_they_must_be() {
        let path = std::env::temp_dir().join(format!("hal-pieces-{}", std::process::id()));
        let mut file = WholeFile::new(Growing::create(&path).unwrap());
        for at in 1..=3000 {
            file.write_all(b"#1234567\n1!\n").unwrap();
            file.end_record(Some(at));
        }
        let ends: Vec<_> = file.pieces.iter().map(|p| p.0).collect();
        let lengths: Vec<_> = ends.windows(2).map(|e| e[1] - e[0]).collect();
        assert!(lengths.len() > 2 && ends.iter().all(|e| e % 12 == 0), "{ends:?}");
        let full = lengths.split_last().unwrap().1;
        assert!(full.iter().all(|n| (super::PIECE..super::PIECE + 12).contains(n)), "{lengths:?}");
        file.finish().unwrap();
        assert_eq!(file.kept(), (36_000, Some(3000)));
        fs::remove_file(&path).unwrap();
    }
}
