//! The folder in which a test runs. It has links to the machine's own files, with some of them
//! replaced, so that files which the machine writes stay out of the machine's folder. What a used machine has
//! remembered (parameters, the tool in the spindle, the journal) is not there, and its tool table is a copy.

use super::{
    outcome::{Complaint, Spot},
    test::{MachineFile, Test},
};
use crate::ini::plain;
use hal_ini::{Ini, Purpose, beside};
use std::{
    collections::BTreeSet,
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
    let written = Written::of(&folder, &name);
    written.set_up(&folder, &copy, Path::new("")).map_err(wrong)?;
    for (file, text) in &test.replace {
        let plain = Path::new(&file.name).components().all(|c| matches!(c, Component::Normal(_)));
        if !plain || Path::new(&file.name).components().count() != 1 {
            let text = format!("'{}' is not a file beside '{name}'", file.name);
            return Err(Complaint::new(&file.spot, text));
        }
        let path = copy.join(&file.name);
        // What stands there is a link to the machine's own file, or nothing.
        fs::remove_file(&path).or_else(is_gone).map_err(wrong)?;
        fs::write(path, text).map_err(wrong)?;
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

fn is_gone(error: io::Error) -> io::Result<()> {
    if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) }
}

/// Endings of the names beside such files, the INI file and the tool table.
const BESIDE: [&str; 3] = ["bak", "spindle", "journal"];

/// Files of a machine that it writes, relative to its folder.
#[derive(Debug, Default)]
struct Written {
    /// Parameters, positions, the tool in the spindle, the journal: a test begins without them.
    remembered: BTreeSet<PathBuf>,
    /// The tool table: a test works on a copy.
    copied: BTreeSet<PathBuf>,
}

impl Written {
    /// Finds the files that the INI file `name` of a folder names. A script names none.
    fn of(folder: &Path, name: &str) -> Self {
        let mut out = Self::default();
        let path = folder.join(name);
        // The start of the machine reports an error of the file.
        let Some(ini) =
            path.extension().filter(|e| *e == "ini").and_then(|_| Ini::read(&path).ok())
        else {
            return out;
        };
        let inside = |name: &str| {
            let path = beside(folder, name);
            let inside = path.strip_prefix(folder).ok()?;
            let is_plain = inside.components().all(|c| matches!(c, Component::Normal(_)));
            is_plain.then(|| inside.to_path_buf())
        };
        for (purpose, name) in ini.machine_files() {
            match purpose {
                Purpose::Script => {}
                Purpose::Tools => out.copied.extend(inside(name)),
                Purpose::Memory => out.remembered.extend(inside(name)),
            }
        }
        let named = out.remembered.iter().chain(&out.copied).cloned();
        for file in named.chain([PathBuf::from(name)]).collect::<Vec<_>>() {
            for ending in BESIDE {
                let mut longer = file.clone().into_os_string();
                longer.push(format!(".{ending}"));
                out.remembered.extend([PathBuf::from(longer), file.with_extension(ending)]);
            }
        }
        out
    }

    /// Links every entry of a folder of the machine into its copy, but for what the machine writes. `at` is the folder's
    /// path from the machine's own.
    fn set_up(&self, from: &Path, to: &Path, at: &Path) -> io::Result<()> {
        links(from, to, &|name| self.is_about(&at.join(name)))?;
        for entry in fs::read_dir(from)? {
            let name = entry?.file_name();
            let (path, own) = (at.join(&name), from.join(&name));
            if self.copied.contains(&path) {
                fs::copy(own, to.join(&name))?;
            } else if self.is_about(&path) && own.is_dir() && name != hal_output::STATES_FOLDER {
                fs::create_dir(to.join(&name))?;
                self.set_up(&own, &to.join(&name), &path)?;
            }
        }
        Ok(())
    }

    /// Returns whether a file is one of these, or a folder has one of them.
    fn is_about(&self, path: &Path) -> bool {
        let mut all = self.remembered.iter().chain(&self.copied);
        path.ends_with(hal_output::STATES_FOLDER) || all.any(|file| file.starts_with(path))
    }
}
