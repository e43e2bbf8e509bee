//! A folder that is held open, and the files below it.

use crate::{
    error::OpenError,
    name::{FileName, RelativeName},
    new_file::NewFile,
    opening,
};
use rustix::{
    fd::{AsFd, BorrowedFd, OwnedFd},
    fs::{AtFlags, Dir, FileType, Mode, OFlags, Stat, fstat, mkdirat, open, statat, unlinkat},
    io::Errno,
};
use std::{
    fs::File,
    path::{Path, PathBuf},
};

/// Mode of folders that are made, less the user's mask.
const FOLDER: Mode = Mode::from_raw_mode(0o755);
/// Mode of files that are made, less the user's mask: none of them can be run.
pub(crate) const FILE: Mode = Mode::from_raw_mode(0o644);
/// Bits of a mode that let somebody run a file.
pub(crate) const EXECUTE: u32 = 0o111;

/// A folder that is held open. Nobody can replace it between the check of a name and its use.
#[derive(Debug)]
pub struct Beneath {
    fd: OwnedFd,
    path: PathBuf,
}

/// A file of a folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The name with the folders on the way.
    pub name: Box<str>,
    /// Size in bytes.
    pub bytes: u64,
    /// Seconds since 1970 of the last change.
    pub modified: f64,
}

impl Beneath {
    /// Opens a folder that the machine's owner names. Links in this path are the owner's.
    ///
    /// # Errors
    /// There is no such folder, or the system refuses.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
        match open(path, flags, Mode::empty()) {
            Ok(fd) => Ok(Self { fd, path: path.to_owned() }),
            Err(Errno::NOTDIR) => Err(OpenError::NoFolder { path: path.into() }),
            Err(e) => Err(OpenError::system(path, e)),
        }
    }

    /// Opens a folder below this one; makes it first if `make` is set.
    ///
    /// # Errors
    /// A link or another file is there, or the system refuses.
    pub fn inside(&self, name: &FileName, make: bool) -> Result<Self, OpenError> {
        let path = self.path.join(name.as_str());
        if make {
            match mkdirat(&self.fd, name.as_str(), FOLDER) {
                Ok(()) | Err(Errno::EXIST) => {}
                Err(e) => return Err(OpenError::system(&path, e)),
            }
        }
        let flags = OFlags::RDONLY | OFlags::DIRECTORY;
        let opened =
            opening::open(&self.fd, &self.path, &name.clone().into(), flags, Mode::empty());
        match opened {
            Ok(fd) => Ok(Self { fd, path }),
            Err(OpenError::System { kind: std::io::ErrorKind::NotADirectory, .. }) => {
                Err(OpenError::NoFolder { path: path.into() })
            }
            Err(e) => Err(e),
        }
    }

    /// Opens the folder of a file below this one, and makes the folders on the way if `make` is set.
    ///
    /// # Errors
    /// As [`Self::inside`].
    pub fn folder_of(&self, name: &RelativeName, make: bool) -> Result<Self, OpenError> {
        let fd = self.fd.try_clone();
        let fd = fd.map_err(|e| {
            OpenError::system(&self.path, Errno::from_io_error(&e).unwrap_or(Errno::IO))
        })?;
        let own = Self { fd, path: self.path.clone() };
        name.folders().iter().try_fold(own, |folder, part| folder.inside(part, make))
    }

    /// Returns the path of the folder, as it was opened.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Opens a file to read it. The open never waits.
    ///
    /// # Errors
    /// A link is there or on the way, the name is that of no file, or the system refuses.
    pub fn read(&self, name: &RelativeName) -> Result<File, OpenError> {
        let (fd, _) = self.regular(name, OFlags::RDONLY, Mode::empty())?;
        Ok(fd.into())
    }

    /// Opens a file to read it that has no other name: a hard link to a file elsewhere shows nothing of it.
    ///
    /// # Errors
    /// As [`Self::read`], or the file has another name.
    pub fn read_sole(&self, name: &RelativeName) -> Result<File, OpenError> {
        let (fd, stat) = self.regular(name, OFlags::RDONLY, Mode::empty())?;
        self.sole(name, &stat)?;
        Ok(fd.into())
    }

    /// Opens a file to write behind its end, which it makes where there is none. The file has no other name, and nobody
    /// can run it.
    ///
    /// # Errors
    /// As [`Self::read_sole`], or the file is executable.
    pub fn append(&self, name: &RelativeName) -> Result<File, OpenError> {
        let flags = OFlags::WRONLY | OFlags::APPEND | OFlags::CREATE;
        let (fd, stat) = self.regular(name, flags, FILE)?;
        self.sole(name, &stat)?;
        if stat.st_mode & EXECUTE != 0 {
            return Err(OpenError::Program { path: self.shown(name) });
        }
        Ok(fd.into())
    }

    /// Begins a file that replaces another, or is new.
    ///
    /// # Errors
    /// What is there may not be replaced (see [`NewFile::finish`]), or the system refuses.
    pub fn replace(&self, name: &FileName) -> Result<NewFile, OpenError> {
        NewFile::begin(self, name)
    }

    /// Removes a file that may be replaced.
    ///
    /// # Errors
    /// There is none, it may not be replaced, or the system refuses.
    pub fn remove(&self, name: &FileName) -> Result<(), OpenError> {
        let path = self.path.join(name.as_str());
        if self.check_replaceable(name)?.is_none() {
            return Err(OpenError::Missing { path: path.into() });
        }
        unlinkat(&self.fd, name.as_str(), AtFlags::empty()).map_err(|e| OpenError::system(&path, e))
    }

    /// Lists the files of this folder, and those of the folders below it down to a depth (0: none), by name. Links, hidden
    /// files and names that nobody could open are left out; `most` bounds the number of entries that are looked at.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn list(&self, depth: usize, most: usize) -> Result<Vec<Found>, OpenError> {
        let (mut list, mut left) = (Vec::new(), most);
        self.collect("", depth, &mut left, &mut list)?;
        list.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(list)
    }

    fn collect(
        &self,
        before: &str,
        depth: usize,
        left: &mut usize,
        list: &mut Vec<Found>,
    ) -> Result<(), OpenError> {
        let fail = |e| OpenError::system(&self.path, e);
        for entry in Dir::read_from(&self.fd).map_err(fail)? {
            if *left == 0 {
                break;
            }
            *left -= 1;
            let entry = entry.map_err(fail)?;
            let Ok(text) = entry.file_name().to_str() else { continue };
            let Ok(name) = FileName::parse(text) else { continue };
            let Ok(stat) = statat(&self.fd, text, AtFlags::SYMLINK_NOFOLLOW) else { continue };
            match FileType::from_raw_mode(stat.st_mode) {
                FileType::RegularFile => list.push(Found {
                    name: format!("{before}{text}").into(),
                    bytes: u64::try_from(stat.st_size).unwrap_or(0),
                    modified: stat.st_mtime as f64 + stat.st_mtime_nsec as f64 * 1e-9,
                }),
                FileType::Directory if depth > 0 => {
                    // A folder that went meanwhile, or that nobody may read, has no files.
                    let Ok(inner) = self.inside(&name, false) else { continue };
                    let before = format!("{before}{text}/");
                    inner.collect(&before, depth - 1, left, list).unwrap_or_default();
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Checks that a file may be replaced or removed: a file with this one name, of this user, which nobody can run.
    /// Returns its record, or `None` where there is none.
    pub(crate) fn check_replaceable(&self, name: &FileName) -> Result<Option<Stat>, OpenError> {
        let path = || self.path.join(name.as_str()).into();
        let stat = match statat(&self.fd, name.as_str(), AtFlags::SYMLINK_NOFOLLOW) {
            Err(Errno::NOENT) => return Ok(None),
            found => found.map_err(|e| OpenError::system(&self.path.join(name.as_str()), e))?,
        };
        let me = rustix::process::geteuid().as_raw();
        match FileType::from_raw_mode(stat.st_mode) {
            FileType::Symlink => Err(OpenError::Link { path: path() }),
            FileType::RegularFile if stat.st_mode & EXECUTE != 0 => {
                Err(OpenError::Program { path: path() })
            }
            FileType::RegularFile if stat.st_nlink > 1 => Err(OpenError::HardLink { path: path() }),
            FileType::RegularFile if stat.st_uid != me => {
                Err(OpenError::Owner { path: path(), owner: stat.st_uid, expected: me })
            }
            FileType::RegularFile => Ok(Some(stat)),
            _ => Err(OpenError::NoFile { path: path() }),
        }
    }

    /// Opens a regular file.
    fn regular(
        &self,
        name: &RelativeName,
        flags: OFlags,
        mode: Mode,
    ) -> Result<(OwnedFd, Stat), OpenError> {
        // The open of a pipe that nothing fills returns at once, and so does that of a device.
        let flags = flags | OFlags::NONBLOCK | OFlags::NOCTTY;
        let fd = opening::open(&self.fd, &self.path, name, flags, mode).map_err(|e| match e {
            // A pipe without a reader, a socket, a folder.
            OpenError::System { kind, .. }
                if kind == std::io::ErrorKind::IsADirectory || self.is_no_file(name) =>
            {
                OpenError::NoFile { path: self.shown(name) }
            }
            e => e,
        })?;
        let stat = fstat(&fd).map_err(|e| OpenError::system(&self.shown(name), e))?;
        if FileType::from_raw_mode(stat.st_mode) != FileType::RegularFile {
            return Err(OpenError::NoFile { path: self.shown(name) });
        }
        Ok((fd, stat))
    }

    fn is_no_file(&self, name: &RelativeName) -> bool {
        let opened = opening::open(&self.fd, &self.path, name, OFlags::PATH, Mode::empty())
            .and_then(|fd| fstat(&fd).map_err(|e| OpenError::system(&self.path, e)));
        opened.is_ok_and(|s| FileType::from_raw_mode(s.st_mode) != FileType::RegularFile)
    }

    fn sole(&self, name: &RelativeName, stat: &Stat) -> Result<(), OpenError> {
        if stat.st_nlink > 1 {
            return Err(OpenError::HardLink { path: self.shown(name) });
        }
        Ok(())
    }

    fn shown(&self, name: &RelativeName) -> Box<Path> {
        self.path.join(name.path()).into()
    }
}

impl AsFd for Beneath {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }
}
