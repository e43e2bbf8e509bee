//! The folder in which a test runs. It has links to the machine's own files, with some of them
//! replaced, so that files which the machine writes stay out of the machine's folder.

use super::{
    outcome::{Complaint, Spot},
    test::{MachineFile, Test},
};
use crate::ini::plain;
use std::{
    fs::{self, DirBuilder},
    io,
    os::unix::fs::{DirBuilderExt, symlink},
    path::{Component, Path, PathBuf},
};

/// Folder for the sockets of instances.
pub(super) const RUNTIME: &str = ".run";
/// Number of folder names that are tried.
const MAX_ATTEMPTS: u32 = 1000;

/// A folder for one run. Drop removes it.
#[derive(Debug)]
pub(super) struct Stage {
    path: PathBuf,
}

impl Stage {
    /// Creates an empty folder for the `number`-th run of this process.
    pub(super) fn new(number: u32) -> io::Result<Self> {
        let process = std::process::id();
        for attempt in 0..MAX_ATTEMPTS {
            let path = std::env::temp_dir().join(format!("haltest-{process}-{number}-{attempt}"));
            // A folder that exists already may belong to another user.
            match DirBuilder::new().mode(0o700).create(&path) {
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                made => {
                    made?;
                    let stage = Self { path };
                    fs::create_dir(stage.path.join(RUNTIME))?;
                    return Ok(stage);
                }
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        // Files that cannot be removed stay in the folder for temporary files.
        drop(fs::remove_dir_all(&self.path));
    }
}

/// Sets the machine up in `stage`. Returns the machine's folder there and the name of its script.
pub(super) fn set(test: &Test, stage: &Path) -> Result<(PathBuf, String), Complaint> {
    let Some(machine) = &test.machine else {
        return Err(Complaint::new(&Spot::default(), "there is no machine"));
    };
    let spot = &machine.spot;
    let (folder, name) = found(machine)?;
    let wrong = |error: io::Error| {
        Complaint::new(spot, format!("the folder of the test cannot be made: {}", plain(&error)))
    };
    // The neighbours of the machine's folder also become neighbours of the copy, because files may
    // name `../other`.
    let around = stage.join("machines");
    fs::create_dir_all(&around).map_err(wrong)?;
    let copy = match (folder.parent(), folder.file_name()) {
        (Some(parent), Some(own)) => {
            links(parent, &around, &|n| n == own).map_err(wrong)?;
            around.join(own)
        }
        _ => around.join("machine"),
    };
    fs::create_dir_all(&copy).map_err(wrong)?;
    let is_replaced = |n: &std::ffi::OsStr| test.replace.iter().any(|(r, _)| *r.name == *n);
    links(&folder, &copy, &is_replaced).map_err(wrong)?;
    for (file, text) in &test.replace {
        let plain = Path::new(&file.name).components().all(|c| matches!(c, Component::Normal(_)));
        if !plain || Path::new(&file.name).components().count() != 1 {
            let text = format!("'{}' is not a file beside '{name}'", file.name);
            return Err(Complaint::new(&file.spot, text));
        }
        fs::write(copy.join(&file.name), text).map_err(wrong)?;
    }
    Ok((copy, name))
}

/// Returns the machine's folder and the name of its script.
fn found(machine: &MachineFile) -> Result<(PathBuf, String), Complaint> {
    let MachineFile { spot, shown, path } = machine;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    let folder = folder.unwrap_or_else(|| Path::new(".")).canonicalize();
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
    let missing = |why: &str| Complaint::new(spot, format!("the machine '{shown}': {why}"));
    let (Ok(folder), Some(name)) = (folder, name) else {
        return Err(missing("there is no such file"));
    };
    if !folder.join(&name).is_file() {
        let names = fs::read_dir(&folder).into_iter().flatten().flatten();
        let mut names: Vec<String> =
            names.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.retain(|n| n.ends_with(".hal") || n.ends_with(".ini"));
        names.sort();
        let near = crate::language::hint::nearest(&name, names.iter().map(String::as_str));
        return Err(missing("there is no such file").near(near));
    }
    Ok((folder, name))
}

/// Links every entry of one folder into another, except those that `without` excludes.
fn links(from: &Path, to: &Path, without: &dyn Fn(&std::ffi::OsStr) -> bool) -> io::Result<()> {
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        if !without(&entry.file_name()) {
            symlink(entry.path(), to.join(entry.file_name()))?;
        }
    }
    Ok(())
}
