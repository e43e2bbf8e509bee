//! Files of programs: where they are, and what is refused.

use super::*;
use hal_ini::Ini;
use hal_job::places::Places;
use std::{fs, os::unix::fs::PermissionsExt as _};

/// A folder with the files of a machine.
struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("hal-{name}-{}", std::process::id()));
        fs::create_dir_all(folder.join("nc_files")).unwrap();
        fs::write(folder.join("m.ini"), "[EMC]\n").unwrap();
        Self(folder.canonicalize().unwrap())
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn output(&self) -> Output {
        Places::read(&Ini::read(&self.at("m.ini")).unwrap(), &self.0).unwrap().output
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap_or_default();
    }
}

fn log(name: &str, append: bool) -> FileAction {
    FileAction::Open { kind: FileKind::Log, name: name.into(), append }
}

fn line(text: &str) -> FileAction {
    FileAction::Line(FileKind::Log, text.into())
}

#[test]
fn a_file_is_replaced_or_continued() {
    let place = Place::new("task-files");
    let output = place.output();
    let bounds = Bounds { output: Some(&output), program: None, own: &[] };
    let mut files = ProgramFiles::default();
    let mut act = |action: &FileAction| files.act(action, bounds).unwrap();
    assert!(!place.at("output").exists());
    act(&line("nowhere"));
    for name in ["log.txt", "probes/part 1/log.txt"] {
        for (append, wanted) in [(false, "a\n"), (true, "a\na\n"), (false, "a\n"), (false, "a\n")] {
            act(&log(name, append));
            act(&line("a"));
            act(&FileAction::Close(FileKind::Log));
            act(&line("nowhere"));
            let path = place.at("output").join(name);
            assert_eq!(fs::read_to_string(&path).unwrap(), wanted);
            assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o111, 0);
        }
    }
    let names: Vec<_> = fs::read_dir(place.at("output")).unwrap().collect();
    assert_eq!(names.len(), 2, "no temporary file is left: {names:?}");
}

#[test]
fn a_continued_file_is_bounded_and_never_read() {
    let place = Place::new("task-appended");
    let output = place.output();
    let bounds = Bounds { output: Some(&output), program: None, own: &[] };
    // A file without content, which would fill the memory if it were read.
    let path = place.at("output/log.txt");
    fs::create_dir(place.at("output")).unwrap();
    File::create(&path).unwrap().set_len(MAX_LEN - 3).unwrap();
    let mut files = ProgramFiles::default();
    files.act(&log("log.txt", true), bounds).unwrap();
    files.act(&line("ab"), bounds).unwrap();
    let why = files.act(&line(""), bounds).unwrap_err();
    assert!(why.ends_with("log.txt: longer than 1 GiB"), "{why}");
    assert_eq!(fs::metadata(&path).unwrap().len(), MAX_LEN);
}

#[test]
fn a_program_writes_only_below_the_output_folder() {
    let place = Place::new("task-bounds");
    let output = place.output();
    fs::create_dir(place.at("output")).unwrap();
    for name in ["m.hal", "output/tool.tbl", "output/M101", "nc_files/job.ngc", "people"] {
        fs::write(place.at(name), "kept").unwrap();
    }
    fs::set_permissions(place.at("output/M101"), fs::Permissions::from_mode(0o755)).unwrap();
    let link = |to: &Path, name: &str| std::os::unix::fs::symlink(to, place.at(name)).unwrap();
    link(&place.at("people"), "output/link.txt");
    link(&place.at("new.txt"), "output/new.txt");
    link(&place.at("nc_files"), "output/folder");
    fs::hard_link(place.at("people"), place.at("output/hard.txt")).unwrap();
    fs::create_dir(place.at("output/empty")).unwrap();
    let table = place.at("output/tool.tbl");
    let own = [&*table];
    let program = place.at("nc_files/job.ngc");
    let bounds = Bounds { output: Some(&output), program: Some(&program), own: &own };
    let mut files = ProgramFiles::default();
    let whole = place.at("people").display().to_string();
    let long = "a".repeat(256);
    for (name, why) in [
        ("/dev/full", "absolute, must be relative; programs write below"),
        (&*whole, "output/people"),
        ("../people", "'..', which leads to the folder above; programs write below"),
        ("a/../../people", "'..'"),
        ("..", "'..'"),
        (".", "a part of the name is empty"),
        ("", "the name is empty"),
        (".bashrc", "hidden"),
        ("a/.ssh/keys", "hidden"),
        ("a\0b", "U+0000"),
        ("caf\u{65}\u{301}", "U+0301"),
        ("a\u{ff0f}people", "U+FF0F"),
        (&long, "256 bytes"),
        ("link.txt", "a symbolic link"),
        ("new.txt", "a symbolic link"),
        ("folder/job.ngc", "a file of the machine"),
        ("folder/new.ngc", "a symbolic link"),
        ("hard.txt", "other names"),
        ("M101", "an executable file"),
        ("empty", "not a file"),
        ("tool.tbl", "a file of the machine"),
    ] {
        for append in [false, true] {
            let said = files.act(&log(name, append), bounds).unwrap_err();
            assert!(said.contains(why), "{name:?} {append}: {said}");
        }
    }
    for name in ["m.hal", "output/tool.tbl", "output/M101", "nc_files/job.ngc", "people"] {
        assert_eq!(fs::read_to_string(place.at(name)).unwrap(), "kept", "{name}");
    }
    assert!(!place.at("new.txt").exists());
    let nowhere = Bounds { output: None, ..bounds };
    assert!(files.act(&log("a.txt", false), nowhere).unwrap_err().contains("no INI file"));
}
