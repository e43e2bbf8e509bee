//! The folder that a test runs in: the machine's own files, with some of them replaced, so that
//! nothing that the machine writes ends up among them.

use super::{
    outcome::{Complaint, Spot},
    test::{Machine, Test},
};
use crate::ini::plain;
use std::{
    fs::{self, DirBuilder},
    io,
    os::unix::fs::{DirBuilderExt, symlink},
    path::{Component, Path, PathBuf},
};

/// Where instances have their sockets.
pub(super) const RUNTIME: &str = ".run";
/// How many names of folders are tried.
const MAX_ATTEMPTS: u32 = 1000;

/// A folder for one run; it is removed in the end.
#[derive(Debug)]
pub(super) struct Stage {
    path: PathBuf,
}

impl Stage {
    /// An empty one, for the `number`-th run of this process.
    pub(super) fn new(number: u32) -> io::Result<Self> {
        let process = std::process::id();
        for attempt in 0..MAX_ATTEMPTS {
            let path = std::env::temp_dir().join(format!("haltest-{process}-{number}-{attempt}"));
            // One that is there already may be another user's.
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
        // What cannot be removed stays in the folder for temporary files.
        drop(fs::remove_dir_all(&self.path));
    }
}

/// Sets the machine up in `stage`: its folder, and the name of its script in it.
pub(super) fn set(test: &Test, stage: &Path) -> Result<(PathBuf, String), Complaint> {
    let Some(machine) = &test.machine else {
        return Err(Complaint::new(&Spot::default(), "there is no machine"));
    };
    let spot = &machine.spot;
    let (folder, name) = found(machine)?;
    let wrong = |error: io::Error| {
        Complaint::new(spot, format!("the folder of the test cannot be made: {}", plain(&error)))
    };
    // What is beside the machine's folder is beside its copy, too: files may name `../other`.
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
            let text = format!("'{}' is no file beside '{name}'", file.name);
            return Err(Complaint::new(&file.spot, text));
        }
        fs::write(copy.join(&file.name), text).map_err(wrong)?;
    }
    Ok((copy, name))
}

/// The machine's folder and the name of its script.
fn found(machine: &Machine) -> Result<(PathBuf, String), Complaint> {
    let Machine { spot, shown, path } = machine;
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
        let near = crate::hint::nearest(&name, names.iter().map(String::as_str));
        return Err(missing("there is no such file").near(near));
    }
    Ok((folder, name))
}

/// Links everything of a folder into another one, but for what is left out.
fn links(from: &Path, to: &Path, without: &dyn Fn(&std::ffi::OsStr) -> bool) -> io::Result<()> {
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        if !without(&entry.file_name()) {
            symlink(entry.path(), to.join(entry.file_name()))?;
        }
    }
    Ok(())
}
