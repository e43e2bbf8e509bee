//! The files, tools and values that a program sees.

use crate::{machine::Machine, program_error::ProgramError};
use hal_beneath::{Beneath, FileName, RelativeName};
use hal_gcode::{Environment, Source, Text, tool::Tool};
use hal_remap::Functions;
use std::{
    cell::RefCell,
    collections::BTreeMap,
    fs::{File, Metadata},
    io,
    os::unix::fs::{FileExt, MetadataExt},
    path::Path,
    sync::Arc,
};

/// The world of a program that runs without its machine.
pub struct World {
    /// The machine.
    pub machine: Machine,
    /// Values of HAL items, as options give them.
    pub hal: BTreeMap<String, f64>,
    /// Functions in Python, if they run here.
    pub functions: Option<RefCell<Functions>>,
}

impl World {
    /// Returns the world of a program, and starts the functions in Python of its machine.
    pub fn with_functions(mut machine: Machine, hal: BTreeMap<String, f64>) -> Self {
        let functions = machine.start_functions(false).map(RefCell::new);
        Self { machine, hal, functions }
    }
}

/// The most bytes that are read from a pipe.
const MAX_PIPE: u64 = 1 << 30;

/// A file that is read while its program runs. Its size and time of change stay what they were, or reading ends.
struct Opened {
    file: File,
    version: Version,
}

/// Size and time of change of a file.
pub type Version = (u64, i64, i64);

/// Opens a program. It is read in parts, so that memory does not grow with the file.
///
/// # Errors
/// The file cannot be opened.
pub fn program(path: &Path) -> Result<Text, String> {
    let wrong = |e: &io::Error| format!("{}: {}", path.display(), hal_output::reason(e));
    if !std::fs::metadata(path).map_err(|e| wrong(&e))?.is_file() {
        // A pipe can be read only once, and a folder not at all. The open of a pipe that nothing fills never returns.
        let bytes = hal_ini::file::contents(path, MAX_PIPE).map_err(|e| wrong(&e))?;
        let bytes = bytes.ok_or_else(|| format!("{}: it is larger than 1 GiB", path.display()))?;
        return Ok(Arc::new(bytes));
    }
    text_of(File::open(path).map_err(|e| wrong(&e))?).map_err(|e| wrong(&e))
}

/// Opens a program of a machine. Of the folder of uploads, only the file itself is opened, and no link to another.
///
/// # Errors
/// The file cannot be opened.
pub fn program_of(machine: &Machine, path: &Path) -> Result<Text, String> {
    let uploads = machine.places.as_ref().map(|places| &places.uploads);
    let whole = |path: &Path| std::path::absolute(path).ok();
    let uploads = uploads.filter(|uploads| path.parent().and_then(whole) == whole(uploads));
    let Some(uploads) = uploads else { return program(path) };
    let wrong = |why: &dyn core::fmt::Display| format!("{}: {why}", path.display());
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let name = FileName::parse(name).map_err(|why| wrong(&why))?;
    let file = Beneath::open(uploads).and_then(|folder| folder.read_sole(&name.into()));
    text_of(file.map_err(|why| why.to_string())?).map_err(|e| wrong(&hal_output::reason(&e)))
}

/// Opens a program of a machine for people elsewhere: a file of the folder of programs, and no link to another.
///
/// # Errors
/// The file lies elsewhere, or cannot be opened.
pub fn program_from_afar(machine: &Machine, path: &Path) -> Result<Text, ProgramError> {
    // Without an INI file nothing says where the machine's programs are: the caller has chosen the folder.
    let Some(places) = &machine.places else {
        return program_of(machine, path).map_err(|why| ProgramError::Own(why.into()));
    };
    let failed = |why: &io::Error| ProgramError::System {
        path: path.into(),
        why: hal_output::reason(why).into(),
    };
    let whole = |path: &Path| std::path::absolute(path).map_err(|why| failed(&why));
    let (folder, file) = (whole(&places.programs)?, whole(path)?);
    let Some(name) = file.strip_prefix(&folder).ok().and_then(Path::to_str) else {
        return Err(ProgramError::Outside { path: path.into(), programs: folder.into() });
    };
    let name =
        RelativeName::parse(name).map_err(|why| ProgramError::Name { path: path.into(), why })?;
    let uploads = whole(&places.uploads)?;
    let opened = Beneath::open(&folder).and_then(|folder| match file.starts_with(&uploads) {
        true => folder.read_sole(&name),
        false => folder.read(&name),
    });
    text_of(opened.map_err(ProgramError::Open)?).map_err(|why| failed(&why))
}

/// Returns the text of a file that is open, which is read in parts.
///
/// # Errors
/// The system refuses.
pub fn text_of(file: File) -> io::Result<Text> {
    let version = version_of(&file)?;
    Ok(Arc::new(Opened { file, version }))
}

fn version_of(file: &File) -> io::Result<Version> {
    Ok(facts(&file.metadata()?))
}

fn facts(known: &Metadata) -> Version {
    (known.len(), known.mtime(), known.mtime_nsec())
}

/// Returns size and time of change of a file.
///
/// # Errors
/// There is no such file.
pub fn version(path: &Path) -> Result<Version, String> {
    let known = std::fs::metadata(path);
    let known = known.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?;
    Ok(facts(&known))
}

impl Source for Opened {
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<usize, Box<str>> {
        let read = self.file.read_at(buffer, offset).map_err(|e| hal_output::reason(&e))?;
        // After the read: what was read is older than the version that is compared.
        if version_of(&self.file).map_err(|e| hal_output::reason(&e))? != self.version {
            return Err("it has changed since it was opened".into());
        }
        Ok(read)
    }
}

impl World {
    /// Reads the file of a subroutine, or tells why it is not read; `None` if no folder has one of that name.
    ///
    /// The first folder with the name decides: a file that is not read hides those of later folders, so that no other
    /// subroutine of the same name runs in its place.
    fn subroutine(&self, name: &str) -> Option<Result<Text, Box<str>>> {
        // Names of subroutines name no folder, and their files are no links.
        let file = FileName::parse(&format!("{name}.ngc")).ok()?.into();
        self.machine.folders.iter().find_map(|folder| {
            // The folder of a file in the working folder has no name.
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            match Beneath::open(folder).and_then(|folder| folder.read(&file)) {
                Ok(found) => Some(text_of(found).map_err(|e| hal_output::reason(&e).into())),
                Err(e) if e.is_missing() => None,
                Err(e) => Some(Err(e.to_string().into())),
            }
        })
    }
}

impl Environment for World {
    fn open(&self, name: &str) -> Option<Text> {
        // A program's own name comes as it was given; a subroutine's comes without ending.
        if name.ends_with(".ngc") || name.contains('/') {
            let as_given = Path::new(name);
            if as_given.is_file() {
                return program_of(&self.machine, as_given).ok();
            }
        }
        self.subroutine(name)?.ok()
    }

    fn refusal(&self, name: &str) -> Option<Box<str>> {
        self.subroutine(name)?.err()
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        self.machine.tools.find(number).cloned()
    }

    fn ini(&self, section: &str, key: &str) -> Option<f64> {
        let entries = self.machine.ini.as_ref()?.entries();
        let mut found = entries.filter(|e| {
            e.section.eq_ignore_ascii_case(section) && e.name.eq_ignore_ascii_case(key)
        });
        found.next()?.value.trim().parse().ok()
    }

    fn hal(&self, name: &str) -> Option<f64> {
        self.hal.get(&name.to_ascii_lowercase()).copied()
    }

    fn function(&self, name: &str) -> bool {
        self.machine.words.contains(name)
    }

    fn user_code(&self, code: u16) -> Result<bool, Box<str>> {
        self.machine.codes.find(code).map(|found| found.is_some())
    }
}

#[cfg(test)]
mod tests {
    //! Files of subroutines.

    use super::World;
    use crate::machine::{Files, Machine};
    use hal_gcode::Environment as _;
    use std::{collections::BTreeMap, fs, os::unix::fs::symlink};

    #[test]
    fn a_linked_subroutine_is_refused_and_no_other_runs_for_it() {
        let folder = std::env::temp_dir().join(format!("hal-job-linked-{}", std::process::id()));
        for name in ["first", "second"] {
            fs::create_dir_all(folder.join(name)).unwrap();
        }
        let ini = folder.join("m.ini");
        fs::write(&ini, "[RS274NGC]\nSUBROUTINE_PATH = first:second\n").unwrap();
        for name in ["probe", "other"] {
            let text = format!("o<{name}> sub\no<{name}> endsub\n");
            fs::write(folder.join("second").join(format!("{name}.ngc")), text).unwrap();
        }
        symlink("../second/probe.ngc", folder.join("first/probe.ngc")).unwrap();
        let machine = Machine::read(&Files { ini: Some(&ini), ..Files::default() }).unwrap();
        let world = World::with_functions(machine, BTreeMap::new());
        // The one of that name in the second folder does not run in its place.
        assert!(world.open("probe").is_none());
        let why = world.refusal("probe").unwrap();
        assert!(why.contains("first/probe.ngc") && why.contains("a symbolic link"), "{why}");
        assert!(world.open("other").is_some() && world.refusal("other").is_none());
        assert!(world.open("none").is_none() && world.refusal("none").is_none());
        fs::remove_dir_all(&folder).unwrap();
    }
}
