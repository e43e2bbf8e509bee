//! The one call that opens a file below a folder.
//!
//! Linux 5.6 resolves a whole name without links and without leaving the folder (`openat2`). An older kernel, or a sandbox
//! that permits no such call, opens it part by part, each from the descriptor of the one before and none of them a link:
//! since a name has no `..`, both reach the same files.

use crate::{error::OpenError, name::RelativeName};
use rustix::{
    fd::{AsFd, OwnedFd},
    fs::{Mode, OFlags, ResolveFlags, openat, openat2},
    io::Errno,
};
use std::path::Path;

/// Number of times that a name is resolved again while somebody renames folders on the way.
const TRIES: u32 = 16;

/// The way in which a name is resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// By the system, as a whole.
    Whole,
    /// Part by part.
    Parts,
}

/// Opens a file below the folder `at`, whose path is `shown` in errors.
pub(crate) fn open(
    at: impl AsFd,
    shown: &Path,
    name: &RelativeName,
    flags: OFlags,
    mode: Mode,
) -> Result<OwnedFd, OpenError> {
    let opened = match by(Way::Whole, &at, name, flags, mode) {
        // Sandboxes answer with PERM what they do not know; the parts then tell whether it is a real one, and whether what
        // is no folder is a link.
        Err(Errno::NOSYS | Errno::PERM | Errno::NOTDIR) => by(Way::Parts, &at, name, flags, mode),
        opened => opened,
    };
    opened.map_err(|e| OpenError::system(&shown.join(name.path()), e))
}

/// Opens a file in one of the ways.
pub(crate) fn by(
    way: Way,
    at: &impl AsFd,
    name: &RelativeName,
    flags: OFlags,
    mode: Mode,
) -> Result<OwnedFd, Errno> {
    let flags = flags | OFlags::CLOEXEC | OFlags::NOFOLLOW;
    match way {
        Way::Whole => {
            let resolve =
                ResolveFlags::BENEATH | ResolveFlags::NO_SYMLINKS | ResolveFlags::NO_MAGICLINKS;
            let path = name.path();
            let mut opened = Err(Errno::AGAIN);
            for _ in 0..TRIES {
                opened = openat2(at, &path, flags, mode, resolve);
                if !matches!(opened, Err(Errno::AGAIN | Errno::INTR)) {
                    break;
                }
            }
            opened
        }
        Way::Parts => {
            let step = OFlags::PATH | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
            let mut folder: Option<OwnedFd> = None;
            for part in name.folders() {
                let from = folder.as_ref().map_or(at.as_fd(), AsFd::as_fd);
                let opened = openat(from, part.as_str(), step, Mode::empty());
                folder = Some(opened.map_err(|e| link(from, part.as_str(), e))?);
            }
            let from = folder.as_ref().map_or(at.as_fd(), AsFd::as_fd);
            openat(from, name.file().as_str(), flags, mode)
                .map_err(|e| link(from, name.file().as_str(), e))
        }
    }
}

/// Tells a link from another file that is no folder, as the whole way does.
fn link(at: impl AsFd, name: &str, error: Errno) -> Errno {
    use rustix::fs::{AtFlags, FileType, statat};
    let is_link = || {
        statat(at, name, AtFlags::SYMLINK_NOFOLLOW)
            .is_ok_and(|stat| FileType::from_raw_mode(stat.st_mode) == FileType::Symlink)
    };
    if error == Errno::NOTDIR && is_link() { Errno::LOOP } else { error }
}
