//! Target of a written file: the file that a path means, the temporary file, and the replacement.

use rustix::{
    fs::{Gid, OFlags, PROC_SUPER_MAGIC, Uid, fchown, statfs},
    io::Errno,
};
use std::{
    fs::{self, File, Metadata, OpenOptions, Permissions},
    io::{self, ErrorKind},
    os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt, PermissionsExt},
    path::{Path, PathBuf},
    sync::atomic::{AtomicU32, Ordering::Relaxed},
};

/// Maximum number of symbolic links that are followed.
const LINKS: u32 = 40;
/// Number of names that are tried for a temporary file.
const NAMES: u32 = 100;

/// A temporary file beside the file that it will replace. It is removed unless it is moved to its
/// place.
#[derive(Debug)]
pub(crate) struct Target {
    /// `None` if data is written directly to the target, or once the file is in its place.
    temporary: Option<PathBuf>,
    path: PathBuf,
    attributes: Option<Attributes>,
}

/// Permissions and owner for the new file.
#[derive(Clone, Copy, Debug)]
struct Attributes {
    mode: u32,
    /// True if the caller requested this mode, false if it is that of the replaced file.
    is_asked: bool,
    /// Owner and group of the replaced file.
    owner: Option<(u32, u32)>,
}

/// The file that a path means after its links are followed.
pub(crate) enum Meant {
    /// A device, a pipe, or an open file such as `/dev/stdout`, which cannot be replaced.
    Fixed,
    /// A file that does not exist yet.
    New(PathBuf),
    /// A file that exists.
    Old(PathBuf, Metadata),
}

impl Target {
    /// Opens the file to write for this path. With `mode`, the file gets these permissions and
    /// replaces even a read-only file, as in the installation of programs. With `promptly`, a pipe or device is opened
    /// for writes that do not wait, and a pipe without a reader is an error.
    pub(crate) fn open(path: &Path, mode: Option<u32>, promptly: bool) -> io::Result<(Self, File)> {
        let (place, old) = match meant(path)? {
            Meant::Fixed => {
                let flags = if promptly { OFlags::NONBLOCK } else { OFlags::empty() };
                let mut options = OpenOptions::new();
                options.write(true).truncate(true).custom_flags(flags.bits().cast_signed());
                let file = options.open(path).map_err(|e| unread(path, e))?;
                return Ok((
                    Self { temporary: None, path: path.to_owned(), attributes: None },
                    file,
                ));
            }
            Meant::New(place) => (place, None),
            Meant::Old(place, old) => {
                if mode.is_none() {
                    // Without `mode`, a read-only file is not replaced.
                    drop(OpenOptions::new().write(true).open(&place)?);
                }
                (place, Some(old))
            }
        };
        let owner = old.as_ref().map(|old| (old.uid(), old.gid()));
        let kept = mode.or(old.as_ref().map(|old| old.mode() & 0o7777));
        let attributes =
            kept.map(|kept| Attributes { mode: kept, is_asked: mode.is_some(), owner });
        let (temporary, file) =
            temporary(&place, attributes.is_some()).map_err(|e| beside(e, old.is_some()))?;
        Ok((Self { temporary: Some(temporary), path: place, attributes }, file))
    }

    /// Returns whether the file is in its place.
    pub(crate) const fn is_settled(&self) -> bool {
        self.temporary.is_none()
    }

    /// Stores the file on the disk, moves it to its place and stores its name there, in this order: whenever the power
    /// is lost, the old file or the whole new one is there.
    pub(crate) fn settle_stored(&mut self, file: &File) -> io::Result<()> {
        if self.is_settled() {
            return Ok(());
        }
        place(&mut Placing { target: self, file })
    }

    /// Moves the file to its place.
    pub(crate) fn settle(&mut self, file: &File) -> io::Result<()> {
        let Some(temporary) = &self.temporary else { return Ok(()) };
        if let Some(Attributes { mode, is_asked, owner }) = self.attributes {
            if let Some((uid, gid)) = owner {
                // Only root can change the owner. Otherwise the file belongs to the writer.
                let _ = fchown(file, None, Some(Gid::from_raw(gid)));
                let _ = fchown(file, Some(Uid::from_raw(uid)), None);
            }
            let set = file.set_permissions(Permissions::from_mode(mode));
            // Some file systems have no permissions.
            if is_asked {
                set?;
            }
        }
        fs::rename(temporary, &self.path)?;
        self.temporary = None;
        Ok(())
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            // If the removal fails, the file that remains has a recognizable name.
            drop(fs::remove_file(temporary));
        }
    }
}

/// The steps by which a file replaces another.
trait Disk {
    fn store_file(&mut self) -> io::Result<()>;
    fn rename(&mut self) -> io::Result<()>;
    fn store_folder(&mut self) -> io::Result<()>;
}

/// A written file on its way to its place.
struct Placing<'a> {
    target: &'a mut Target,
    file: &'a File,
}

fn place(disk: &mut impl Disk) -> io::Result<()> {
    disk.store_file()?;
    disk.rename()?;
    disk.store_folder()
}

impl Disk for Placing<'_> {
    fn store_file(&mut self) -> io::Result<()> {
        self.file.sync_all()
    }

    fn rename(&mut self) -> io::Result<()> {
        self.target.settle(self.file)
    }

    fn store_folder(&mut self) -> io::Result<()> {
        store(folder(&self.target.path))
    }
}

/// Stores the names of a folder on the disk.
pub(crate) fn store(folder: &Path) -> io::Result<()> {
    match File::open(folder)?.sync_all() {
        // Some file systems store names on their own only.
        Err(e) if e.kind() == ErrorKind::InvalidInput => Ok(()),
        stored => stored,
    }
}

/// Follows links one by one, because the last link may lead to a file that does not exist.
pub(crate) fn meant(path: &Path) -> io::Result<Meant> {
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        let found = match fs::symlink_metadata(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Meant::New(path)),
            found => found?,
        };
        if found.is_dir() {
            return Err(Errno::ISDIR.into());
        }
        if found.is_file() {
            return Ok(Meant::Old(path, found));
        }
        // Links in /proc mean open files, regardless of their text.
        if !found.is_symlink() || is_of_processes(folder(&path)) {
            return Ok(Meant::Fixed);
        }
        path = folder(&path).join(fs::read_link(&path)?);
    }
    Err(Errno::LOOP.into())
}

fn is_of_processes(folder: &Path) -> bool {
    statfs(folder).is_ok_and(|s| s.f_type == PROC_SUPER_MAGIC)
}

pub(crate) fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Creates a temporary file with a unique name in the folder of `path`.
fn temporary(path: &Path, is_private: bool) -> io::Result<(PathBuf, File)> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let mut options = OpenOptions::new();
    options.write(true).create_new(true).mode(if is_private { 0o600 } else { 0o666 });
    for _ in 0..NAMES {
        let n = NEXT.fetch_add(1, Relaxed);
        let name = format!(".ferrule-{}-{n}.part", std::process::id());
        let temporary = folder(path).join(name);
        match options.open(&temporary) {
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            opened => return opened.map(|file| (temporary, file)),
        }
    }
    Err(ErrorKind::AlreadyExists.into())
}

/// Explains the error of a pipe that no process reads.
fn unread(path: &Path, error: io::Error) -> io::Error {
    let is_pipe = || fs::metadata(path).is_ok_and(|m| m.file_type().is_fifo());
    if error.raw_os_error() == Some(Errno::NXIO.raw_os_error()) && is_pipe() {
        return io::Error::new(error.kind(), "no process reads this pipe");
    }
    error
}

/// Extends the error if the file is writable but its folder is not.
fn beside(error: io::Error, is_old: bool) -> io::Error {
    match error.kind() {
        ErrorKind::PermissionDenied if is_old => io::Error::new(
            error.kind(),
            format!("{}: no file can be made beside it", crate::reason(&error)),
        ),
        _ => error,
    }
}

#[cfg(test)]
mod tests {
    use super::{Disk, place};
    use std::{collections::BTreeSet, io};

    /// A disk that stores what it must at once, and everything else at any time or never.
    #[derive(Default)]
    struct Unsure {
        is_file_stored: bool,
        is_renamed: bool,
        is_name_stored: bool,
        /// Number of steps until the disk fails.
        good: usize,
        /// The files that a loss of power can leave under the name, after each step.
        left: Vec<BTreeSet<&'static str>>,
    }

    impl Unsure {
        fn step(&mut self, change: impl FnOnce(&mut Self)) -> io::Result<()> {
            self.good = self.good.checked_sub(1).ok_or(io::ErrorKind::StorageFull)?;
            change(self);
            let new = if self.is_file_stored { ["new"].as_slice() } else { &["new", "part"] };
            let mut left = BTreeSet::new();
            if !self.is_name_stored {
                left.insert("old");
            }
            if self.is_renamed {
                left.extend(new);
            }
            self.left.push(left);
            Ok(())
        }
    }

    impl Disk for Unsure {
        fn store_file(&mut self) -> io::Result<()> {
            self.step(|disk| disk.is_file_stored = true)
        }

        fn rename(&mut self) -> io::Result<()> {
            self.step(|disk| disk.is_renamed = true)
        }

        fn store_folder(&mut self) -> io::Result<()> {
            self.step(|disk| disk.is_name_stored = disk.is_renamed)
        }
    }

    #[test]
    fn a_loss_of_power_leaves_the_old_file_or_the_whole_new_one() {
        let left: [&[&str]; 3] = [&["old"], &["new", "old"], &["new"]];
        for good in 0..=left.len() {
            let mut disk = Unsure { good, ..Unsure::default() };
            assert_eq!(place(&mut disk).is_ok(), good == left.len(), "{good}");
            let found: Vec<Vec<&str>> =
                disk.left.iter().map(|left| left.iter().copied().collect()).collect();
            assert_eq!(found, left[..good], "a failure ends it: {good}");
        }
    }
}
