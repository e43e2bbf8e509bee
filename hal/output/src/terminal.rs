//! Terminals: a person at one, colours, and the files of what programs remember for the person.

use crate::checksum;
use std::{
    env, fs,
    os::{
        fd::AsFd,
        unix::{
            ffi::OsStrExt as _,
            fs::{DirBuilderExt as _, PermissionsExt as _},
        },
    },
    path::{Path, PathBuf},
};

/// Returns whether a person types and reads at a terminal that can move its cursor.
#[must_use]
pub fn is_person() -> bool {
    let is_terminal = rustix::termios::isatty(std::io::stdin());
    is_terminal && rustix::termios::isatty(std::io::stdout()) && is_able()
}

/// Returns whether this file descriptor is a terminal that shows colours, and its user wants them.
#[must_use]
pub fn is_coloured(fd: impl AsFd) -> bool {
    let refused = env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
    !refused && rustix::termios::isatty(fd) && is_able()
}

fn is_able() -> bool {
    env::var("TERM").is_ok_and(|term| !matches!(term.as_str(), "" | "dumb"))
}

/// Returns `ferrule/NAME` in the user's state folder, which it creates if necessary, for this user alone. Returns `None`
/// without a home folder.
#[must_use]
pub fn state_file(name: &str) -> Option<PathBuf> {
    let absolute = |name: &str| env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let state =
        absolute("XDG_STATE_HOME").or_else(|| Some(absolute("HOME")?.join(".local/state")))?;
    let folder = state.join("ferrule");
    fs::DirBuilder::new().recursive(true).mode(0o700).create(&folder).ok()?;
    let is_open = fs::metadata(&folder).is_ok_and(|about| about.permissions().mode() & 0o077 != 0);
    if is_open {
        // Another user's folder stays as it is; who needs a private one looks at it.
        fs::set_permissions(&folder, fs::Permissions::from_mode(0o700)).unwrap_or_default();
    }
    Some(folder.join(name))
}

/// Returns the begin of the names of a machine's files in the user's state folder: the name of its INI file, and a number
/// that the path of it gives. Returns `None` without a home folder.
#[must_use]
pub fn state_of_machine(ini: &Path) -> Option<PathBuf> {
    state_file(&name_of_machine(ini))
}

fn name_of_machine(ini: &Path) -> String {
    let hash = checksum::of(ini.as_os_str().as_bytes());
    // A caller gives the name an ending, which replaces the part behind a dot.
    let stem = ini.file_stem().unwrap_or_default().to_string_lossy().replace('.', "_");
    format!("{stem}-{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::name_of_machine;
    use std::{collections::BTreeSet, path::Path};

    #[test]
    fn machines_have_files_of_their_own() {
        let machines = ["/a/mill.ini", "/b/mill.ini", "/a/mill.old.ini", "/a/mill.new.ini"];
        let files =
            machines.map(|m| Path::new(&name_of_machine(Path::new(m))).with_extension("var"));
        assert_eq!(files.iter().collect::<BTreeSet<_>>().len(), machines.len(), "{files:?}");
    }
}
