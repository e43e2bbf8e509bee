//! Files that only the panel's user may reach: accounts, the key of the certificate, and the audit log.
//!
//! They lie in folders of mode 0700, and never where a program, an upload or the machine's own files are: a writer
//! of those folders could replace them.

use crate::{folders::Folders, options::Options};
use std::{
    os::unix::fs::PermissionsExt as _,
    path::{Path, PathBuf},
};

/// Returns the options with the places of these files.
///
/// # Errors
/// A file lies where others could reach it, or beside the INI file.
pub(crate) fn placed(options: &Options, folders: &Folders) -> Result<Options, String> {
    let ini = options.ini_file.as_deref();
    let place = |file: &Option<PathBuf>, what: &str| -> Result<Option<PathBuf>, String> {
        file.as_deref().map(|file| place(file, what, ini, folders)).transpose()
    };
    Ok(Options {
        accounts: place(&options.accounts, "the file of accounts")?,
        certificate: place(&options.certificate, "the file with the key")?,
        audit: place(&options.audit, "the audit log")?,
        ..options.clone()
    })
}

/// Returns the place of a file: a name without a folder is one in the user's state folder.
fn place(
    file: &Path,
    what: &str,
    ini: Option<&Path>,
    folders: &Folders,
) -> Result<PathBuf, String> {
    let whole = std::path::absolute(file).map_err(|e| hal_output::reason(&e))?;
    let shown = file.display();
    let is_name = file.parent().is_some_and(|folder| folder.as_os_str().is_empty());
    if is_name {
        let name = file.to_str().unwrap_or_default();
        let kept = hal_output::state_file(name).ok_or_else(|| {
            format!("{shown}: there is no home folder for {what}: name a folder of mode 0700")
        })?;
        let beside = ini.and_then(Path::parent).map(|folder| folder.join(file));
        let old = [Some(whole), beside].into_iter().flatten().find(|old| old.exists());
        if let Some(old) = old.filter(|_| !kept.exists()) {
            return Err(moved(&old, what, &kept));
        }
        return private(&kept, what).map(|()| kept);
    }
    let folder = whole.parent().unwrap_or(Path::new("/"));
    let machine = ini.and_then(|ini| std::path::absolute(ini).ok());
    let machine = machine.as_deref().and_then(Path::parent);
    let same = |a: &Path, b: &Path| a.canonicalize().ok() == b.canonicalize().ok();
    if machine.is_some_and(|machine| same(machine, folder)) || folders.is_open_to_others(folder) {
        let kept = hal_output::state_file(&whole.file_name().unwrap_or_default().to_string_lossy());
        return Err(moved(&whole, what, &kept.unwrap_or_else(|| "PRIVATE/FILE".into())));
    }
    private(&whole, what).map(|()| whole)
}

/// Returns the refusal of a file beside the INI file. It is moved by a person, who knows who has written it.
fn moved(old: &Path, what: &str, kept: &Path) -> String {
    format!(
        "{}: {what} lies beside the machine's files, must be in a folder of mode 0700: look at what is in it, then \
         mv {} {}",
        old.display(),
        old.display(),
        kept.display()
    )
}

/// Checks that only this user reaches the folder of a file.
fn private(file: &Path, what: &str) -> Result<(), String> {
    let folder = file.parent().unwrap_or(Path::new("/"));
    let is_private = hal_beneath::is_private(folder).map_err(|e| e.to_string())?;
    if is_private {
        return Ok(());
    }
    let mode = folder.metadata().map_or(0, |about| about.permissions().mode() & 0o7777);
    Err(format!(
        "{}: others can reach the folder of {what} (mode {mode:04o}), must be this user's with mode 0700: chmod 700 {}",
        file.display(),
        folder.display()
    ))
}

#[cfg(test)]
mod tests {
    //! Places of files that only one user may reach.

    use super::{Folders, Options, placed};
    use clap::Parser as _;
    use std::{fs, os::unix::fs::PermissionsExt as _};

    #[test]
    fn private_files_lie_in_private_folders_apart_from_the_machine() {
        let folder = std::env::temp_dir().join(format!("halpanel-private-{}", std::process::id()));
        for (name, mode) in [
            ("machine", 0o700),
            ("machine/programs/uploads", 0o700),
            ("open", 0o755),
            ("own", 0o700),
        ] {
            fs::create_dir_all(folder.join(name)).unwrap();
            fs::set_permissions(folder.join(name), fs::Permissions::from_mode(mode)).unwrap();
        }
        std::os::unix::fs::symlink("machine", folder.join("link")).unwrap();
        let folders = Folders::of(folder.join("machine/programs"));
        let ini = folder.join("machine/m.ini");
        fs::write(&ini, "[EMC]\n").unwrap();
        let place = |option: &str, name: &str| {
            let words = ["halpanel".into(), "--ini-file".into(), ini.clone().into_os_string()];
            let file = [option.into(), folder.join(name).into_os_string()];
            placed(&Options::parse_from(words.into_iter().chain(file)), &folders)
        };
        for option in ["--accounts", "--certificate", "--audit"] {
            for (name, why) in [
                ("machine/people", "lies beside the machine's files"),
                ("link/people", "lies beside the machine's files"),
                ("machine/programs/uploads/people", "lies beside the machine's files"),
                ("open/people", "(mode 0755), must be this user's with mode 0700: chmod 700"),
                ("none/people", "No such file"),
            ] {
                let said = place(option, name).unwrap_err();
                assert!(said.contains(why), "{option} {name}: {said}");
            }
            place(option, "own/people").unwrap();
        }
        let kept = place("--accounts", "own/people").unwrap().accounts;
        assert_eq!(kept, Some(folder.join("own/people")));
        fs::remove_dir_all(&folder).unwrap();
    }
}
