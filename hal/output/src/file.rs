//! Files that are replaced as a whole, and files that grow.

use crate::target::Target;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::{
    fs::{File, Permissions},
    io::{self, BufWriter, Error, ErrorKind, Write},
    os::unix::fs::{MetadataExt, PermissionsExt as _},
    path::Path,
    time::SystemTime,
};

/// Size of the write buffer in bytes.
const BUFFER_BYTES: usize = 1 << 16;
/// Longest time for which a pipe or device may take nothing, if writes to it do not wait.
const TIMEOUT: Timespec = Timespec { tv_sec: 1, tv_nsec: 0 };

/// Writes a file as a whole. The old file stays in place until the new one is complete and stored
/// on disk. The permissions are kept, and links to the file stay valid. Devices and pipes are
/// written directly.
///
/// # Errors
/// The system returned an error. The old file is then unchanged.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = Whole::create(path)?;
    file.write_all(bytes)?;
    file.finish()
}

/// Writes a file as a whole with these permissions, even over a read-only file.
///
/// # Errors
/// As [`write()`].
pub fn install(path: &Path, bytes: &[u8], mode: u32) -> io::Result<()> {
    let mut file = Whole::open(path, Some(mode), false)?;
    file.write_all(bytes)?;
    file.finish()
}

/// A file that appears under its name when it is finished. If it is dropped before that, nothing
/// remains.
#[derive(Debug)]
pub struct Whole {
    target: Target,
    out: BufWriter<Out>,
}

/// An open file, or a pipe or device that may be open for writes that do not wait.
#[derive(Debug)]
struct Out(File);

impl Whole {
    /// Starts to write a file.
    ///
    /// # Errors
    /// The system returned an error.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::open(path, None, false)
    }

    /// Starts to write a file, as [`Self::create`] does. A pipe or device must take something within a second: a pipe
    /// without a reader is refused, and a write to one whose reader does not read fails.
    ///
    /// # Errors
    /// The system returned an error.
    pub fn create_promptly(path: &Path) -> io::Result<Self> {
        Self::open(path, None, true)
    }

    fn open(path: &Path, mode: Option<u32>, promptly: bool) -> io::Result<Self> {
        let (target, file) = Target::open(path, mode, promptly)?;
        Ok(Self { target, out: BufWriter::with_capacity(BUFFER_BYTES, Out(file)) })
    }

    /// Completes the file: stores it on disk and moves it to its place.
    ///
    /// # Errors
    /// The system returned an error. The old file is then unchanged.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.flush()?;
        let Out(file) = self.out.get_ref();
        if file.metadata()?.is_file() {
            // Some file systems report a full disk only here.
            file.sync_all()?;
        }
        self.target.settle(file)
    }

    /// Completes the file, as [`Self::finish`] does, and stores its name on the disk too.
    ///
    /// # Errors
    /// The system returned an error. The old file is then unchanged, unless only its name could not be stored.
    pub(crate) fn finish_stored(mut self) -> io::Result<()> {
        self.out.flush()?;
        let Out(file) = self.out.get_ref();
        self.target.settle_stored(file)
    }

    /// Gives the file these permissions and this time of its last change, behind everything that was written.
    pub(crate) fn set(&mut self, mode: u32, time: SystemTime) -> io::Result<()> {
        self.out.flush()?;
        let Out(file) = self.out.get_ref();
        // Some file systems have neither.
        file.set_permissions(Permissions::from_mode(mode)).unwrap_or_default();
        file.set_modified(time).unwrap_or_default();
        Ok(())
    }
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.0.write(bytes) {
            Err(e) if e.kind() == ErrorKind::WouldBlock => {
                let ready = poll(&mut [PollFd::new(&self.0, PollFlags::OUT)], Some(&TIMEOUT))?;
                if ready == 0 {
                    let why = "its reader has taken nothing for a second";
                    return Err(Error::new(ErrorKind::TimedOut, why));
                }
                // The caller repeats the write.
                Err(ErrorKind::Interrupted.into())
            }
            written => written,
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
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

/// A file that can be read while it grows. It appears under its name with its first records. It
/// ends with a whole record even if the disk becomes full.
#[derive(Debug)]
pub struct Growing {
    target: Target,
    /// `None` after a failure.
    file: Option<File>,
    /// Length of the whole records, in bytes.
    bytes: u64,
}

impl Growing {
    /// Starts to write a file. The old file stays in place until the first records are written.
    ///
    /// # Errors
    /// The system returned an error.
    pub fn create(path: &Path) -> io::Result<Self> {
        let (target, file) = Target::open(path, None, false)?;
        Ok(Self { target, file: Some(file), bytes: 0 })
    }

    /// Writes a file with these records, which are on the disk before it takes its place: a loss of power leaves the old
    /// file or this one with all of them.
    ///
    /// # Errors
    /// The system returned an error. The old file is then unchanged, unless only its name could not be stored.
    pub fn create_stored(path: &Path, records: &[u8]) -> io::Result<Self> {
        let mut new = Self::create(path)?;
        if let Some(file) = &mut new.file {
            file.write_all(records)?;
            new.target.settle_stored(file)?;
            new.bytes = records.len() as u64;
        }
        Ok(new)
    }

    /// Appends whole records. If the write fails, the part that was written is removed, and nothing
    /// more can be written.
    ///
    /// # Errors
    /// The system returned an error, now or before.
    pub fn append(&mut self, records: &[u8]) -> io::Result<()> {
        let Some(file) = &mut self.file else { return Err(ended()) };
        let written = file.write_all(records);
        let written = written.and_then(|()| self.target.settle(file));
        if written.is_ok() {
            self.bytes = self.bytes.saturating_add(records.len() as u64);
            return Ok(());
        }
        if file.metadata().is_ok_and(|m| m.is_file()) {
            // If truncation fails, the file ends with a partial record, which readers detect.
            file.set_len(self.bytes).unwrap_or_default();
        }
        self.file = None;
        written
    }

    /// Returns the length of the whole records, in bytes.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Returns the inode of the file, which the file keeps when it appears under its name.
    #[must_use]
    pub fn inode(&self) -> Option<u64> {
        self.file.as_ref()?.metadata().ok().map(|m| m.ino())
    }

    /// Returns whether the file has appeared under its name.
    #[must_use]
    pub const fn is_there(&self) -> bool {
        self.target.is_settled()
    }

    /// Completes the file.
    ///
    /// # Errors
    /// The system has not stored everything, or returned an error before.
    pub fn finish(mut self) -> io::Result<()> {
        let file = self.file.take().ok_or_else(ended)?;
        self.target.settle(&file)?;
        close_file(file)
    }
}

/// Closes a file that was written. Network file systems report here what they could not store.
///
/// # Errors
/// The system has not stored everything.
pub fn close_file(file: File) -> io::Result<()> {
    nix::unistd::close(file).map_err(Error::from)
}

fn ended() -> Error {
    Error::new(ErrorKind::BrokenPipe, "writing has ended")
}

#[cfg(test)]
mod tests;
