//! A file that appears under its name when it is whole.

use crate::{
    beneath::{Beneath, FILE},
    error::OpenError,
    name::FileName,
};
use rustix::{
    fd::OwnedFd,
    fs::{AtFlags, Mode, OFlags, fchmod, openat, renameat, unlinkat},
    io::Errno,
};
use std::{
    fs::File,
    io::{self, Write},
    path::PathBuf,
    sync::atomic::{AtomicU32, Ordering::Relaxed},
};

/// Number of names that are tried for a temporary file.
const NAMES: u32 = 100;

/// A file on its way to its name. If it is dropped before, nothing remains.
#[derive(Debug)]
pub struct NewFile {
    folder: Beneath,
    name: FileName,
    /// Name until then; `None` once the file has its own.
    temporary: Option<String>,
    file: File,
}

impl NewFile {
    pub(crate) fn begin(folder: &Beneath, name: &FileName) -> Result<Self, OpenError> {
        folder.check_replaceable(name)?;
        let folder = folder.folder_of(&name.clone().into(), false)?;
        let (temporary, fd) = temporary(&folder)?;
        let temporary = Some(temporary);
        Ok(Self { folder, name: name.clone(), temporary, file: fd.into() })
    }

    /// Stores the file and gives it its name. A file that has the name is replaced, unless it is a link, has another name,
    /// is another user's, or somebody can run it.
    ///
    /// # Errors
    /// What is there may not be replaced, or the system refuses. What was there is then unchanged.
    pub fn finish(mut self) -> Result<(), OpenError> {
        self.file.sync_all().map_err(|e| self.refused(&e))?;
        self.settle()
    }

    /// Gives the file its name now, and returns it to be written on.
    ///
    /// # Errors
    /// As [`Self::finish`].
    pub fn appear(mut self) -> Result<File, OpenError> {
        self.settle()?;
        self.file.try_clone().map_err(|e| self.refused(&e))
    }

    fn settle(&mut self) -> Result<(), OpenError> {
        let Some(temporary) = &self.temporary else { return Ok(()) };
        if let Some(old) = self.folder.check_replaceable(&self.name)? {
            let mode = Mode::from_raw_mode(old.st_mode & 0o666);
            // Some file systems have no permissions.
            fchmod(&self.file, mode).unwrap_or_default();
        }
        renameat(&self.folder, temporary.as_str(), &self.folder, self.name.as_str())
            .map_err(|e| OpenError::system(&self.path(), e))?;
        self.temporary = None;
        Ok(())
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join(self.name.as_str())
    }

    fn refused(&self, error: &io::Error) -> OpenError {
        OpenError::system(&self.path(), Errno::from_io_error(error).unwrap_or(Errno::IO))
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            // If the removal fails, the file that remains has a recognizable name, which no list shows.
            unlinkat(&self.folder, temporary.as_str(), AtFlags::empty()).unwrap_or_default();
        }
    }
}

/// Creates a file of a name that no other has.
fn temporary(folder: &Beneath) -> Result<(String, OwnedFd), OpenError> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let flags = OFlags::RDWR | OFlags::CREATE | OFlags::EXCL | OFlags::APPEND | OFlags::NOFOLLOW;
    let mut last = Errno::EXIST;
    for _ in 0..NAMES {
        // Relaxed: only the number matters.
        let n = NEXT.fetch_add(1, Relaxed);
        let name = format!(".ferrule-{}-{n}.part", std::process::id());
        match openat(folder, name.as_str(), flags | OFlags::CLOEXEC, FILE) {
            Ok(fd) => return Ok((name, fd)),
            Err(e) => last = e,
        }
        if last != Errno::EXIST {
            break;
        }
    }
    Err(OpenError::system(folder.path(), last))
}
