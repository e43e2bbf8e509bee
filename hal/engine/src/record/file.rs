//! A file that holds whole records only, at any moment.

use crate::ends;
use std::{
    fs::File,
    io::{Result, Write},
};

/// The file of a recording. Records are collected here; only whole ones reach the file.
#[derive(Debug)]
pub(crate) struct WholeFile {
    file: File,
    buffer: Vec<u8>,
    /// How many bytes of `buffer` are whole records.
    whole: usize,
    /// How many bytes are in the file.
    written: u64,
}

impl WholeFile {
    /// A file that was just created.
    pub(crate) fn new(file: File) -> Self {
        ends::record(0, 0);
        Self { file, buffer: Vec::new(), whole: 0, written: 0 }
    }

    /// Everything that was written so far belongs to whole records.
    pub(crate) const fn end_record(&mut self) {
        self.whole = self.buffer.len();
    }

    /// How many bytes of whole records are not in the file yet.
    pub(crate) const fn waiting(&self) -> usize {
        self.whole
    }

    /// Writes the whole records to the file.
    ///
    /// # Errors
    /// The system refuses. The file then ends at the last whole record that it took before.
    pub(crate) fn put(&mut self) -> Result<()> {
        let whole = self.buffer.get(..self.whole).unwrap_or_default();
        let then = self.written + whole.len() as u64;
        // Should the process be killed while it writes, somebody else puts the file right.
        ends::record(self.written, then);
        if let Err(e) = self.file.write_all(whole) {
            // A device and a pipe keep what they were given.
            drop(self.file.set_len(self.written));
            return Err(e);
        }
        self.written = then;
        ends::record(then, then);
        self.buffer.drain(..self.whole);
        self.whole = 0;
        Ok(())
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.buffer.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    /// The end: what there is is whole.
    fn flush(&mut self) -> Result<()> {
        self.end_record();
        self.put()
    }
}

#[cfg(test)]
mod tests {
    use super::WholeFile;
    use std::{fs, io::Write};

    #[test]
    fn only_whole_records_reach_the_file() {
        let path = std::env::temp_dir().join(format!("hal-whole-{}", std::process::id()));
        let mut file = WholeFile::new(fs::File::create(&path).unwrap());
        let inside = || fs::read_to_string(&path).unwrap();
        file.write_all(b"#1\n1!\n").unwrap();
        file.put().unwrap();
        assert_eq!((inside().as_str(), file.waiting()), ("", 0));
        file.end_record();
        file.write_all(b"#2\n0").unwrap();
        assert_eq!(file.waiting(), 6);
        file.put().unwrap();
        assert_eq!((inside().as_str(), file.waiting()), ("#1\n1!\n", 0));
        file.write_all(b"!\n").unwrap();
        file.flush().unwrap();
        assert_eq!(inside(), "#1\n1!\n#2\n0!\n");
        fs::remove_file(&path).unwrap();
    }
}
