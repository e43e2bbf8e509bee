//! Files that programs write: `LOGOPEN`, `LOGAPPEND` and `PROBEOPEN`.
//!
//! A program comes from anywhere, so that it may name only files in the folders of the INI file and of the program, none
//! that is hidden, and none that the machine needs.

use crate::outside::{FileAction, FileKind};
use hal_output::Growing;
use std::{
    collections::BTreeMap,
    fs::{File, Metadata, OpenOptions},
    io::{Error, ErrorKind, Write},
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

/// Largest file in bytes.
const MAX_LEN: u64 = 1 << 30;
/// Endings of programs, and of files that a machine consists of.
const ENDINGS: [&str; 19] = [
    "ngc", "nc", "tap", "gcode", "ini", "inc", "hal", "tcl", "py", "sh", "so", "comp", "tbl",
    "var", "spindle", "journal", "ui", "glade", "xml",
];

/// The open files of a program.
#[derive(Debug, Default)]
pub(super) struct ProgramFiles(BTreeMap<FileKind, (PathBuf, Output)>);

/// The files that a program must leave alone, and the folders that it may write to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds<'a> {
    pub(super) ini: Option<&'a Path>,
    pub(super) program: Option<&'a Path>,
    /// Files that the task itself writes, and those that the INI file names.
    pub(super) own: &'a [&'a Path],
}

/// A file that is replaced, or one that is continued.
#[derive(Debug)]
enum Output {
    New(Growing),
    Continued(Option<File>),
}

impl ProgramFiles {
    /// Opens a file, writes a line to it, or closes it.
    pub(super) fn act(&mut self, action: &FileAction, bounds: Bounds<'_>) -> Result<(), String> {
        match action {
            FileAction::Open { kind, name, append } => {
                self.close(*kind)?;
                let path = bounds.path(name).map_err(|why| format!("{name}: {why}"))?;
                let output = open(&path, *append).map_err(|e| failed(&path, &e))?;
                self.0.insert(*kind, (path, output));
                Ok(())
            }
            FileAction::Line(kind, text) => match self.0.get_mut(kind) {
                Some((path, output)) => {
                    output.append(format!("{text}\n").as_bytes()).map_err(|e| failed(path, &e))
                }
                None => Ok(()),
            },
            FileAction::Close(kind) => self.close(*kind),
        }
    }

    fn close(&mut self, kind: FileKind) -> Result<(), String> {
        match self.0.remove(&kind) {
            Some((path, Output::New(file))) => file.finish().map_err(|e| failed(&path, &e)),
            Some((_, Output::Continued(_))) | None => Ok(()),
        }
    }
}

impl Bounds<'_> {
    /// Returns the whole path of a file that a program names. A relative name is in the INI file's folder, or, without an
    /// INI file, in the program's.
    fn path(&self, name: &str) -> Result<PathBuf, String> {
        let folder = |file: Option<&Path>| -> Option<PathBuf> {
            let folder = std::path::absolute(file?).ok()?.parent()?.canonicalize().ok()?;
            // All files are below the root.
            folder.parent().is_some().then_some(folder)
        };
        let folders = [folder(self.ini), folder(self.program)];
        let base = folders.iter().flatten().next().ok_or("there is no folder for it")?;
        let path = base.join(name);
        let file = path.file_name().ok_or("not a file")?.to_owned();
        let parent = path.parent().unwrap_or(base).canonicalize();
        let parent = parent.map_err(|e| hal_output::reason(&e))?;
        // A link leads elsewhere, whatever its name says.
        let path = parent.join(&file);
        let path = match path.canonicalize() {
            Ok(path) => path,
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(hal_output::reason(&e)),
            Err(_) if path.symlink_metadata().is_ok() => {
                return Err("a link to a file that is not there".to_owned());
            }
            Err(_) => path,
        };
        let below = || folders.iter().flatten().filter_map(|folder| path.strip_prefix(folder).ok());
        if below().next().is_none() {
            let shown: Vec<_> = folders.iter().flatten().map(|f| f.display().to_string()).collect();
            let shown = shown.join(" or ");
            return Err(format!("outside the folders of the machine and its program: {shown}"));
        }
        if below().all(is_hidden) {
            return Err("hidden: its name or that of a folder begins with a dot".to_owned());
        }
        let known = std::fs::metadata(&path).ok();
        if known.as_ref().is_some_and(|known| !known.is_file()) {
            // The open of a pipe that nothing reads never returns.
            return Err("not a file".to_owned());
        }
        if self.is_of_machine(&path, known.as_ref()) {
            return Err("a file of the machine, which a program cannot replace".to_owned());
        }
        Ok(path)
    }

    /// Returns whether the machine needs a file.
    fn is_of_machine(&self, path: &Path, known: Option<&Metadata>) -> bool {
        let mut own = self.own.iter().copied().chain(self.ini).chain(self.program);
        let runs = known.is_some_and(|known| known.permissions().mode() & 0o111 != 0);
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let is_named = ENDINGS.iter().any(|known| known.eq_ignore_ascii_case(ending));
        // A file that is not there yet has no canonical path, but its folder has.
        let whole = |file: &Path| -> Option<PathBuf> {
            Some(file.parent()?.canonicalize().ok()?.join(file.file_name()?))
        };
        let is_own = own.any(|file| {
            whole(file).as_deref() == Some(path)
                || file.canonicalize().is_ok_and(|file| file == path)
        });
        runs || is_named || is_own
    }
}

/// Returns whether a part of a path begins with a dot, as the files that shells and programs read on their own.
fn is_hidden(path: &Path) -> bool {
    path.iter().any(|part| part.as_encoded_bytes().starts_with(b"."))
}

impl Output {
    /// Writes a whole line, or nothing.
    fn append(&mut self, line: &[u8]) -> Result<(), Error> {
        let more = line.len() as u64;
        let is_over = |len: u64| len.saturating_add(more) > MAX_LEN;
        let too_long = || Error::other("longer than 1 GiB");
        match self {
            Self::New(file) if is_over(file.bytes()) => Err(too_long()),
            Self::New(file) => file.append(line),
            Self::Continued(open) => {
                let Some(file) = open else { return Err(Error::other("writing has ended")) };
                let before = file.metadata()?.len();
                if is_over(before) {
                    return Err(too_long());
                }
                let written = file.write_all(line);
                if written.is_err() {
                    // A line that was written in part is taken back.
                    file.set_len(before).unwrap_or_default();
                    *open = None;
                }
                written
            }
        }
    }
}

/// Opens a file to replace it, or to write behind its end.
fn open(path: &Path, append: bool) -> Result<Output, Error> {
    if append && path.exists() {
        let file = OpenOptions::new().append(true).open(path)?;
        return Ok(Output::Continued(Some(file)));
    }
    let mut file = Growing::create(path)?;
    // The file appears now, also without a line.
    file.append(b"")?;
    Ok(Output::New(file))
}

fn failed(path: &Path, error: &Error) -> String {
    format!("{}: {}", path.display(), hal_output::reason(error))
}

/// Replaces a file as a whole.
pub(super) fn written(path: &Path, text: &str) -> Result<(), String> {
    hal_output::write(path, text.as_bytes()).map_err(|e| failed(path, &e))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with the files of a machine.
    struct Place(PathBuf);

    impl Place {
        fn new(name: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("hal-{name}-{}", std::process::id()));
            std::fs::create_dir_all(folder.join("machine")).unwrap();
            std::fs::create_dir_all(folder.join("jobs")).unwrap();
            Self(folder.canonicalize().unwrap())
        }

        fn at(&self, name: &str) -> PathBuf {
            self.0.join(name)
        }
    }

    impl Drop for Place {
        fn drop(&mut self) {
            std::fs::remove_dir_all(&self.0).unwrap_or_default();
        }
    }

    fn log(name: &str, append: bool) -> FileAction {
        FileAction::Open { kind: FileKind::Log, name: name.into(), append }
    }

    #[test]
    fn a_file_is_replaced_or_continued() {
        let place = Place::new("task-files");
        let (ini, program) = (place.at("machine/m.ini"), place.at("jobs/job.ngc"));
        let bounds = Bounds { ini: Some(&ini), program: Some(&program), own: &[] };
        let path = place.at("machine/log.txt");
        let mut files = ProgramFiles::default();
        let line = |text: &str| FileAction::Line(FileKind::Log, text.into());
        let mut act = |action: &FileAction| files.act(action, bounds).unwrap();
        act(&line("nowhere"));
        for (append, wanted) in [(false, "a\n"), (true, "a\na\n"), (false, "a\n")] {
            act(&log("log.txt", append));
            act(&line("a"));
            act(&FileAction::Close(FileKind::Log));
            act(&line("nowhere"));
            assert_eq!(std::fs::read_to_string(&path).unwrap(), wanted);
        }
    }

    #[test]
    fn a_continued_file_is_bounded_and_never_read() {
        let place = Place::new("task-appended");
        let ini = place.at("machine/m.ini");
        let bounds = Bounds { ini: Some(&ini), program: None, own: &[] };
        // A file without content, which would fill the memory if it were read.
        let path = place.at("machine/log.txt");
        File::create(&path).unwrap().set_len(MAX_LEN - 3).unwrap();
        let mut files = ProgramFiles::default();
        files.act(&log("log.txt", true), bounds).unwrap();
        let line = |text: &str| FileAction::Line(FileKind::Log, text.into());
        files.act(&line("ab"), bounds).unwrap();
        let why = files.act(&line(""), bounds).unwrap_err();
        assert!(why.ends_with("log.txt: longer than 1 GiB"), "{why}");
        assert_eq!(std::fs::metadata(&path).unwrap().len(), MAX_LEN);
    }

    #[test]
    fn a_program_writes_only_where_it_may() {
        let place = Place::new("task-bounds");
        let (ini, program) = (place.at("machine/m.ini"), place.at("jobs/job.ngc"));
        let (journal, code) = (place.at("machine/m.journal"), place.at("machine/M101"));
        for file in [&ini, &program, &code] {
            std::fs::write(file, "kept").unwrap();
        }
        std::fs::set_permissions(&code, std::fs::Permissions::from_mode(0o755)).unwrap();
        std::os::unix::fs::symlink("/etc/hostname", place.at("jobs/link.txt")).unwrap();
        std::os::unix::fs::symlink(&ini, place.at("jobs/ini.txt")).unwrap();
        // Links to files that are not there yet.
        for (link, to) in
            [("out.txt", place.at("elsewhere.txt")), ("in.txt", place.at("jobs/new.txt"))]
        {
            std::os::unix::fs::symlink(to, place.at("jobs").join(link)).unwrap();
        }
        std::fs::create_dir_all(place.at("jobs/.ssh")).unwrap();
        std::os::unix::fs::symlink(place.at("jobs/.ssh"), place.at("jobs/keys")).unwrap();
        std::fs::write(place.at("machine/screw.txt"), "kept").unwrap();
        let screw = place.at("machine/screw.txt");
        let own = [&*journal, &*screw];
        let bounds = Bounds { ini: Some(&ini), program: Some(&program), own: &own };
        let shown = |name: &str| place.at(name).display().to_string();
        let mut files = ProgramFiles::default();
        let (outside, machine) = ("outside the folders of the machine", "a file of the machine");
        let (link, hidden) = ("a link to a file that is not there", "hidden: ");
        for (name, why) in [
            ("/dev/full", outside),
            ("../other.txt", outside),
            (&shown("other.txt"), outside),
            (&shown("jobs/link.txt"), outside),
            ("none/log.txt", "No such file"),
            (".", "not a file"),
            ("..", "not a file"),
            ("m.ini", machine),
            ("new.HAL", machine),
            ("m.journal", machine),
            ("M101", machine),
            (&shown("jobs/ini.txt"), machine),
            (&shown("jobs/out.txt"), link),
            (&shown("jobs/in.txt"), link),
            (&shown("jobs/.bashrc"), hidden),
            (&shown("jobs/.ssh/authorized_keys"), hidden),
            (&shown("jobs/keys/authorized_keys"), hidden),
            (".bashrc", hidden),
            ("screw.txt", machine),
            ("../jobs/sub.NGC", machine),
            ("other.tbl", machine),
            (&shown("jobs/job.ngc"), machine),
            ("../jobs/../machine/m.ini", machine),
            ("../machine", "not a file"),
        ] {
            for append in [false, true] {
                let said = files.act(&log(name, append), bounds).unwrap_err();
                assert!(said.starts_with(&format!("{name}: ")) && said.contains(why), "{said}");
            }
        }
        for file in [&ini, &program, &code] {
            assert_eq!(std::fs::read_to_string(file).unwrap(), "kept");
        }
        assert_eq!(std::fs::read_to_string(&screw).unwrap(), "kept");
        assert!(!place.at("elsewhere.txt").exists() && !place.at("jobs/new.txt").exists());
        for name in ["a.txt", "../jobs/b.txt", &shown("jobs/c.csv")] {
            files.act(&log(name, false), bounds).unwrap();
        }
        assert!(place.at("machine/a.txt").exists() && place.at("jobs/b.txt").exists());
        let nowhere = Bounds { ini: None, program: None, own: &[] };
        assert!(files.act(&log("a.txt", false), nowhere).unwrap_err().contains("no folder"));
        // A program in the root folder does not open the whole disk.
        let root = Bounds { ini: Some(&ini), program: Some(Path::new("/job.ngc")), own: &[] };
        let why = files.act(&log("/tmp/a.txt", false), root).unwrap_err();
        assert!(why.contains(outside), "{why}");
    }
}
