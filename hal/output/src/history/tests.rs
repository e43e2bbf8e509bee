//! Tests of kept states.

// The numbers of system calls are those of this processor.
#[cfg(target_arch = "x86_64")]
mod killed;

use super::{MAX_BYTES, MAX_STATES, STATES_FOLDER, keep, states, write_kept};
use std::{
    env, fs,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
};

/// A temporary folder, removed when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("hal-history-{}-{name}", std::process::id()));
        drop(fs::remove_dir_all(&path));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self) -> PathBuf {
        self.0.join("tool.tbl")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

fn texts(file: &Path) -> Vec<String> {
    let states = states(file).unwrap();
    states.iter().map(|state| String::from_utf8(state.read().unwrap()).unwrap()).collect()
}

#[test]
fn the_last_states_stay_in_their_order() {
    let folder = Folder::new("order");
    let file = folder.file();
    for n in 0..MAX_STATES + 7 {
        write_kept(&file, format!("{n}").as_bytes()).unwrap();
        let first = n.saturating_sub(MAX_STATES);
        let expected: Vec<String> = (first..n).map(|n| format!("{n}")).collect();
        assert_eq!(texts(&file), expected);
    }
    let names = fs::read_dir(folder.0.join(STATES_FOLDER).join("tool.tbl")).unwrap().count();
    assert_eq!(names, MAX_STATES, "nothing else is left beside the states");
}

#[test]
fn a_write_of_the_same_contents_makes_no_state() {
    let folder = Folder::new("same");
    let file = folder.file();
    for text in ["a", "a", "b", "b", "a", "a"] {
        write_kept(&file, text.as_bytes()).unwrap();
        keep(&file).unwrap();
        keep(&file).unwrap();
    }
    assert_eq!(texts(&file), ["a", "b", "a"]);
}

#[test]
fn contents_that_a_person_wrote_between_two_writes_stay() {
    let folder = Folder::new("person");
    let file = folder.file();
    write_kept(&file, b"ours").unwrap();
    fs::write(&file, "a person's").unwrap();
    let time = fs::metadata(&file).unwrap().modified().unwrap();
    write_kept(&file, b"ours again").unwrap();
    assert_eq!(texts(&file), ["a person's"]);
    assert_eq!(states(&file).unwrap()[0].time, time);
}

#[test]
fn states_are_beside_the_file_that_a_link_means() {
    let folder = Folder::new("link");
    fs::create_dir(folder.0.join("own")).unwrap();
    let link = folder.0.join("own/link.tbl");
    symlink(folder.file(), &link).unwrap();
    write_kept(&link, b"1").unwrap();
    write_kept(&link, b"2").unwrap();
    assert_eq!(texts(&link), ["1"]);
    assert_eq!(texts(&folder.file()), ["1"]);
    assert_eq!(fs::read(folder.file()).unwrap(), b"2");
    assert!(!folder.0.join("own").join(STATES_FOLDER).exists());
}

#[test]
fn files_that_are_too_large_and_devices_have_no_states() {
    let folder = Folder::new("large");
    let file = folder.file();
    let large = vec![b'x'; usize::try_from(MAX_BYTES).unwrap() + 1];
    write_kept(&file, &large).unwrap();
    write_kept(&file, b"small").unwrap();
    assert_eq!(texts(&file), [""; 0]);
    write_kept(Path::new("/dev/null"), b"1").unwrap();
    assert!(states(Path::new("/dev/null")).unwrap().is_empty());
}

#[test]
fn an_error_names_the_folder_and_leaves_the_file() {
    let folder = Folder::new("error");
    let file = folder.file();
    write_kept(&file, b"1").unwrap();
    fs::write(folder.0.join(STATES_FOLDER), "no folder").unwrap();
    let why = write_kept(&file, b"2").unwrap_err().to_string();
    assert!(why.contains(STATES_FOLDER), "{why}");
    assert_eq!(fs::read(&file).unwrap(), b"1");
    assert!(states(&file).unwrap().is_empty());
}
