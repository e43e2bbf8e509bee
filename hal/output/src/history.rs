//! Earlier states of a file, in a folder beside it, so that a person can restore one of them.

use crate::{
    file::Whole,
    target::{self, Meant},
};
use rustix::io::Errno;
use std::{
    ffi::OsStr,
    fs::{self, DirBuilder, File},
    io::{self, Error, ErrorKind, Read as _, Write as _},
    os::unix::fs::{DirBuilderExt as _, PermissionsExt as _},
    path::{Path, PathBuf},
    time::SystemTime,
};

/// Number of states that are kept of a file.
pub const MAX_STATES: usize = 20;
/// Largest file whose states are kept, in bytes.
const MAX_BYTES: u64 = 4_000_000;
/// Folder beside the file, with a folder for each file whose states it keeps.
pub const STATES_FOLDER: &str = ".ferrule";

/// A state of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeptState {
    /// Number: a later state has a higher one.
    pub number: u32,
    /// Time at which the file got these contents.
    pub time: SystemTime,
    path: PathBuf,
}

impl KeptState {
    /// Reads the contents.
    ///
    /// # Errors
    /// The system returned an error, or the state is larger than any that is kept.
    pub fn read(&self) -> io::Result<Vec<u8>> {
        contents(&self.path)?.ok_or_else(|| ErrorKind::FileTooLarge.into())
    }
}

/// Writes a file as a whole, as [`crate::write()`] does, and keeps its earlier contents as a state. The last
/// [`MAX_STATES`] states are kept. A device, a pipe, and a file above 4 MB have none. A loss of power at any time
/// leaves the old file or the whole new one, and all earlier states except the oldest, which makes room.
///
/// # Errors
/// The system returned an error, or the earlier contents cannot be kept. The file is then unchanged, unless only its name
/// could not be stored.
pub fn write_kept(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let Some(place) = place(path)? else { return crate::write(path, bytes) };
    if let Some(before) = contents(&place)? {
        if before == bytes {
            return Ok(());
        }
        keep_contents(&place, &before)?;
    }
    let mut file = Whole::create(&place)?;
    file.write_all(bytes)?;
    file.finish_stored()
}

/// Keeps the contents of a file as a state, unless the last state has the same. Without the file nothing is done.
///
/// # Errors
/// The system returned an error.
pub fn keep(path: &Path) -> io::Result<()> {
    let Some(place) = place(path)? else { return Ok(()) };
    contents(&place)?.map_or(Ok(()), |now| keep_contents(&place, &now))
}

fn keep_contents(place: &Path, bytes: &[u8]) -> io::Result<()> {
    let Some(folder) = folder(place) else { return Ok(()) };
    let kept = states_of(place)?;
    let last = kept.last();
    if last.is_some_and(|last| last.read().is_ok_and(|known| known == bytes)) {
        prune(kept, MAX_STATES);
        return Ok(());
    }
    let number = last.map_or(0, |last| last.number).saturating_add(1);
    let state = folder.join(format!("{number:06}"));
    store(&folder, &state, place, bytes).map_err(|e| {
        let why = format!("the earlier contents cannot be kept in {}", folder.display());
        Error::new(e.kind(), format!("{why}: {}", crate::reason(&e)))
    })?;
    prune(kept, MAX_STATES.saturating_sub(1));
    Ok(())
}

/// Writes a state of the file at `place`, with its time. A user who may not read the file may not read its states.
fn store(folder: &Path, state: &Path, place: &Path, bytes: &[u8]) -> io::Result<()> {
    let about = fs::metadata(place)?;
    make(folder)?;
    let mut file = Whole::create(state)?;
    file.write_all(bytes)?;
    file.set(about.permissions().mode() & 0o666, about.modified()?)?;
    file.finish_stored()
}

/// Removes all but the last states.
fn prune(kept: Vec<KeptState>, most: usize) {
    let surplus = kept.len().saturating_sub(most);
    for old in kept.into_iter().take(surplus) {
        // A state that cannot be removed now is surplus at the next time too.
        fs::remove_file(old.path).unwrap_or_default();
    }
}

/// Returns the states of a file, the oldest first.
///
/// # Errors
/// The system returned an error.
pub fn states(path: &Path) -> io::Result<Vec<KeptState>> {
    place(path)?.map_or_else(|| Ok(Vec::new()), |place| states_of(&place))
}

fn states_of(place: &Path) -> io::Result<Vec<KeptState>> {
    let Some(folder) = folder(place) else { return Ok(Vec::new()) };
    let entries = match fs::read_dir(&folder) {
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(Vec::new());
        }
        entries => entries?,
    };
    let mut out = Vec::new();
    for entry in entries {
        let entry = entry?;
        let Some(number) = entry.file_name().to_str().and_then(number) else { continue };
        let about = entry.metadata()?;
        if about.is_file() {
            out.push(KeptState { number, time: about.modified()?, path: entry.path() });
        }
    }
    out.sort_by_key(|state| state.number);
    Ok(out)
}

/// Parses the name of a state.
fn number(name: &str) -> Option<u32> {
    let is_number = name.len() >= 6 && name.bytes().all(|b| b.is_ascii_digit());
    name.parse().ok().filter(|_| is_number)
}

/// Returns the file that a path means, or `None` for a device or a pipe.
fn place(path: &Path) -> io::Result<Option<PathBuf>> {
    Ok(match target::meant(path)? {
        Meant::Fixed => None,
        Meant::New(place) | Meant::Old(place, _) => Some(place),
    })
}

fn folder(place: &Path) -> Option<PathBuf> {
    let name: &OsStr = place.file_name()?;
    Some(target::folder(place).join(STATES_FOLDER).join(name))
}

/// Makes the folder of a file's states, and stores its name on the disk.
fn make(folder: &Path) -> io::Result<()> {
    let Some(all) = folder.parent() else { return Ok(()) };
    for folder in [all, folder] {
        match DirBuilder::new().mode(0o755).create(folder) {
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
            Ok(()) => target::store(target::folder(folder))?,
        }
    }
    Ok(())
}

/// Returns what a file contains, or `None` if there is none or it is too large to be kept.
fn contents(place: &Path) -> io::Result<Option<Vec<u8>>> {
    let file = match File::open(place) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        // The name stands for a folder on the way that is a file.
        Err(e) if e.raw_os_error() == Some(Errno::NOTDIR.raw_os_error()) => return Ok(None),
        file => file?,
    };
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= MAX_BYTES).then_some(bytes))
}

#[cfg(test)]
mod tests;
