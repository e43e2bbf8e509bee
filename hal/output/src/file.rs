//! Files that are whole, and files that grow.

use crate::target::Target;
use std::{
    fs::File,
    io::{self, BufWriter, Error, ErrorKind, Write},
    path::Path,
};

/// Room for what is not written yet.
const ROOM: usize = 1 << 16;

/// Writes a file as a whole: what stood under its name stays until the new file is complete and on
/// the disk. Its permissions stay, and so do links to it. Devices and pipes are written to directly.
///
/// # Errors
/// The system refuses; then what stood there is as it was.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = Whole::create(path)?;
    file.write_all(bytes)?;
    file.finish()
}

/// Writes a file as a whole, with these permissions, even over one that may not be written to.
///
/// # Errors
/// As [`write()`].
pub fn install(path: &Path, bytes: &[u8], mode: u32) -> io::Result<()> {
    let mut file = Whole::open(path, Some(mode))?;
    file.write_all(bytes)?;
    file.finish()
}

/// A file that takes its place when it is finished. Dropped before that, it leaves nothing.
#[derive(Debug)]
pub struct Whole {
    target: Target,
    out: BufWriter<File>,
}

impl Whole {
    /// Begins a file.
    ///
    /// # Errors
    /// The system refuses.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::open(path, None)
    }

    fn open(path: &Path, mode: Option<u32>) -> io::Result<Self> {
        let (target, file) = Target::open(path, mode)?;
        Ok(Self { target, out: BufWriter::with_capacity(ROOM, file) })
    }

    /// Ends the file: it is on the disk and in its place.
    ///
    /// # Errors
    /// The system refuses; then what stood there is as it was.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.flush()?;
        let file = self.out.get_ref();
        if file.metadata()?.is_file() {
            // Some file systems only say here that there is no room.
            file.sync_all()?;
        }
        self.target.settle(file)
    }
}

impl Write for Whole {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// A file that can be read while it grows. It takes its place with its first records, and ends at a
/// whole record also when there is no room for more.
#[derive(Debug)]
pub struct Growing {
    target: Target,
    /// None after a failure.
    file: Option<File>,
    /// How long it is, in whole records.
    bytes: u64,
}

impl Growing {
    /// Begins a file. What stands under its name stays until the first records are written.
    ///
    /// # Errors
    /// The system refuses.
    pub fn create(path: &Path) -> io::Result<Self> {
        let (target, file) = Target::open(path, None)?;
        Ok(Self { target, file: Some(file), bytes: 0 })
    }

    /// Appends whole records. When the system refuses, those of them that were written are taken
    /// back, and nothing more is written.
    ///
    /// # Errors
    /// The system refuses, or has refused before.
    pub fn append(&mut self, records: &[u8]) -> io::Result<()> {
        let Some(file) = &mut self.file else { return Err(ended()) };
        let written = file.write_all(records);
        let written = written.and_then(|()| self.target.settle(file));
        if written.is_ok() {
            self.bytes = self.bytes.saturating_add(records.len() as u64);
            return Ok(());
        }
        if file.metadata().is_ok_and(|m| m.is_file()) {
            // A file that cannot be made shorter ends in a part of a record, which readers find.
            file.set_len(self.bytes).unwrap_or_default();
        }
        self.file = None;
        written
    }

    /// How many bytes of whole records are there.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Whether there is a file of this under its name.
    #[must_use]
    pub const fn is_there(&self) -> bool {
        self.target.is_settled()
    }

    /// Ends the file.
    ///
    /// # Errors
    /// The system has not stored everything, or has refused before.
    pub fn finish(mut self) -> io::Result<()> {
        let file = self.file.take().ok_or_else(ended)?;
        self.target.settle(&file)?;
        nix::unistd::close(file).map_err(Error::from)
    }
}

fn ended() -> Error {
    Error::new(ErrorKind::BrokenPipe, "writing has ended")
}

#[cfg(test)]
mod tests;
