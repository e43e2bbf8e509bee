//! Files that are run: who else could write them.

use crate::{
    beneath::{Beneath, EXECUTE},
    error::OpenError,
    name::FileName,
    opening,
};
use rustix::{
    fs::{FileType, Mode, OFlags, Stat, fstat},
    process::{getegid, geteuid},
};
use std::path::Path;

const GROUP_WRITES: u32 = 0o020;
const OTHERS_WRITE: u32 = 0o002;
/// Mode bit of folders in which only the owner of a file renames it.
const STICKY: u32 = 0o1000;
const OTHERS_USE: u32 = 0o077;
/// First user id of a person; below it are root and the users of system services.
const FIRST_PERSON: u32 = 1000;

/// Checks that a program of a folder is run as its owner wrote it: a file with one name, and neither it nor its folder can
/// be written by another user than this one and root, and neither can a folder above. Returns `false` where there is no executable file.
///
/// A group may write if it is this user's own; that of a system service has members, such as the user of the panel.
///
/// # Errors
/// The file is a link, or another user could have written it.
pub fn check_guarded(folder: &Beneath, name: &FileName) -> Result<bool, OpenError> {
    let path = folder.path().join(name.as_str());
    let opened =
        opening::open(folder, folder.path(), &name.clone().into(), OFlags::PATH, Mode::empty());
    let fd = match opened {
        Err(e) if e.is_missing() => return Ok(false),
        opened => opened?,
    };
    let fail = |e| OpenError::system(&path, e);
    let stat = fstat(&fd).map_err(fail)?;
    match FileType::from_raw_mode(stat.st_mode) {
        FileType::RegularFile => {}
        // With PATH and NOFOLLOW, part by part, a link opens as itself.
        FileType::Symlink => return Err(OpenError::Link { path: path.into() }),
        _ => return Ok(false),
    }
    if stat.st_mode & EXECUTE == 0 {
        return Ok(false);
    }
    if stat.st_nlink > 1 {
        return Err(OpenError::HardLink { path: path.into() });
    }
    check_writers(&path, &stat)?;
    check_writers(folder.path(), &fstat(folder).map_err(fail)?)?;
    for above in real(folder.path()).ancestors().skip(1) {
        let mut stat = rustix::fs::stat(above).map_err(|e| OpenError::system(above, e))?;
        // In a folder such as /tmp everybody makes files, and renames only their own.
        if stat.st_mode & STICKY != 0 {
            stat.st_mode &= !(GROUP_WRITES | OTHERS_WRITE);
        }
        check_writers(above, &stat)?;
    }
    Ok(true)
}

fn check_writers(path: &Path, stat: &Stat) -> Result<(), OpenError> {
    let (me, group) = (geteuid().as_raw(), getegid().as_raw());
    if stat.st_uid != me && stat.st_uid != 0 {
        return Err(OpenError::Owner { path: path.into(), owner: stat.st_uid, expected: me });
    }
    let is_service = me != 0 && me < FIRST_PERSON;
    let by_group = stat.st_mode & GROUP_WRITES != 0 && (stat.st_gid != group || is_service);
    if by_group || stat.st_mode & OTHERS_WRITE != 0 {
        return Err(OpenError::Writable { path: path.into(), mode: stat.st_mode & 0o7777 });
    }
    Ok(())
}

/// Returns whether only this user can reach what is in a folder.
///
/// # Errors
/// There is no such folder.
pub fn is_private(folder: &Path) -> Result<bool, OpenError> {
    let folder = Beneath::open(folder)?;
    let stat = fstat(&folder).map_err(|e| OpenError::system(folder.path(), e))?;
    Ok(stat.st_uid == geteuid().as_raw() && stat.st_mode & OTHERS_USE == 0)
}

/// Returns whether a file or folder is a folder or below it, wherever links on both ways lead. What is not there yet is
/// where its folder is.
#[must_use]
pub fn is_below(path: &Path, folder: &Path) -> bool {
    real(path).starts_with(real(folder))
}

/// Returns the path without links, as far as its folders are there.
fn real(path: &Path) -> std::path::PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    for known in path.ancestors() {
        let Ok(whole) = known.canonicalize() else { continue };
        let rest = path.strip_prefix(known).unwrap_or(Path::new(""));
        // Of what is not there, `..` leads back.
        let mut out = whole;
        for part in rest.components() {
            match part {
                std::path::Component::ParentDir => {
                    out.pop();
                }
                part => out.push(part),
            }
        }
        return out;
    }
    path
}
