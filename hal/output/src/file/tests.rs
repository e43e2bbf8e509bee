//! Tests of files before, during and after writing.

use super::{Growing, Whole, install, write};
use rustix::{
    fs::{CWD, FileType, Mode, mknodat},
    process::{Gid, Uid, geteuid},
    thread::{set_thread_groups, set_thread_res_gid, set_thread_res_uid},
};
use std::{
    fs::{self, File, Permissions},
    io::{Read, Write},
    os::unix::fs::{PermissionsExt, symlink},
    path::{Path, PathBuf},
};

/// A temporary folder, removed when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("hal-output-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Returns the contents of a file in the folder.
    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.join(name)).unwrap()
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        drop(fs::remove_dir_all(&self.0));
    }
}

fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().permissions().mode() & 0o7777
}

fn why(result: std::io::Result<()>) -> String {
    crate::reason(&result.unwrap_err())
}

#[test]
fn a_file_is_replaced_when_it_is_whole() {
    let folder = Folder::new("whole");
    let path = folder.join("a");
    fs::write(&path, "good").unwrap();
    let mut file = Whole::create(&path).unwrap();
    // More than the write buffer holds.
    file.write_all(&[b'x'; 200_000]).unwrap();
    assert_eq!((folder.read("a").as_str(), folder.names().len()), ("good", 2));
    drop(file);
    assert_eq!((folder.read("a").as_str(), folder.names()), ("good", vec!["a".to_owned()]));
    write(&path, b"new").unwrap();
    assert_eq!((folder.read("a").as_str(), folder.names()), ("new", vec!["a".to_owned()]));
}

#[test]
fn permissions_and_links_stay() {
    let folder = Folder::new("links");
    fs::write(folder.join("a"), "old").unwrap();
    fs::set_permissions(folder.join("a"), Permissions::from_mode(0o640)).unwrap();
    symlink("a", folder.join("b")).unwrap();
    symlink(folder.join("b"), folder.join("c")).unwrap();
    symlink("d", folder.join("to-nothing")).unwrap();
    symlink("round", folder.join("round")).unwrap();
    write(&folder.join("c"), b"new").unwrap();
    write(&folder.join("to-nothing"), b"made").unwrap();
    assert_eq!((folder.read("a"), folder.read("d")), ("new".to_owned(), "made".to_owned()));
    assert_eq!(mode(&folder.join("a")), 0o640);
    for link in ["b", "c", "to-nothing"] {
        assert!(folder.join(link).is_symlink(), "{link}");
    }
    assert_eq!(why(write(&folder.join("round"), b"")), "Too many levels of symbolic links");
    // A new file has the user's default permissions.
    fs::write(folder.join("plain"), "").unwrap();
    assert_eq!(mode(&folder.join("d")), mode(&folder.join("plain")));
}

#[test]
fn an_installed_file_has_the_mode_that_is_asked_for() {
    let folder = Folder::new("install");
    let path = folder.join("program");
    for text in ["one", "two"] {
        install(&path, text.as_bytes(), 0o555).unwrap();
        assert_eq!((folder.read("program").as_str(), mode(&path)), (text, 0o555));
    }
}

#[test]
fn what_cannot_be_written_says_why_and_leaves_nothing() {
    let folder = Folder::new("refused");
    fs::create_dir(folder.join("folder")).unwrap();
    fs::write(folder.join("file"), "good").unwrap();
    for (path, want) in [
        ("/dev/full".into(), "No space left on device"),
        (folder.join("folder"), "Is a directory"),
        (folder.join("none/file"), "No such file or directory"),
        (folder.join("file/file"), "Not a directory"),
        (PathBuf::new(), "No such file or directory"),
        ("/proc/self/none".into(), "No such file or directory"),
    ] {
        assert_eq!(why(write(&path, b"text")), want, "{path:?}");
        let mut growing = match Growing::create(&path) {
            Err(e) => {
                assert_eq!(crate::reason(&e), want, "{path:?}");
                continue;
            }
            Ok(growing) => growing,
        };
        assert_eq!(why(growing.append(b"text")), want, "{path:?}");
        assert_eq!(why(growing.append(b"text")), "writing has ended");
        assert_eq!((growing.bytes(), why(growing.finish())), (0, "writing has ended".to_owned()));
    }
    assert_eq!(folder.names(), ["file", "folder"]);
    assert_eq!(folder.read("file"), "good");
}

#[test]
fn devices_and_pipes_are_written_to_directly() {
    let folder = Folder::new("direct");
    write(Path::new("/dev/null"), b"text").unwrap();
    assert!(!Path::new("/dev/null").is_file());
    // `/dev/fd/N` is a link to a file but means the open descriptor.
    let kept = File::create(folder.join("kept")).unwrap();
    let fd = std::os::fd::AsRawFd::as_raw_fd(&kept);
    write(Path::new(&format!("/dev/fd/{fd}")), b"text").unwrap();
    assert_eq!(kept.metadata().unwrap().len(), 4);
    assert_eq!(folder.names(), ["kept"]);
}

#[test]
fn a_pipe_that_takes_nothing_is_an_error() {
    let folder = Folder::new("pipe");
    let path = folder.join("pipe");
    mknodat(CWD, &path, FileType::Fifo, Mode::from_raw_mode(0o600), 0).unwrap();
    let refused = Whole::create_promptly(&path).unwrap_err();
    assert_eq!(crate::reason(&refused), "no process reads this pipe");
    // More than a pipe holds.
    let text = vec![b'x'; 200_000];
    let mut reader = File::options().read(true).write(true).open(&path).unwrap();
    let mut file = Whole::create_promptly(&path).unwrap();
    let written = file.write_all(&text).and_then(|()| file.finish());
    assert_eq!(why(written), "its reader has taken nothing for a second");
    // Whatever a reader takes, however slowly, is written.
    drop(reader);
    reader = File::options().read(true).write(true).open(&path).unwrap();
    let mut file = Whole::create_promptly(&path).unwrap();
    let count = text.len();
    let reading = std::thread::spawn(move || {
        let mut bytes = vec![0; count];
        reader.read_exact(&mut bytes).map(|()| bytes)
    });
    file.write_all(&text).unwrap();
    file.finish().unwrap();
    assert!(reading.join().unwrap().unwrap() == text);
}

#[test]
fn a_private_file_is_private_while_it_is_written() {
    let folder = Folder::new("private");
    fs::write(folder.join("a"), "old").unwrap();
    fs::set_permissions(folder.join("a"), Permissions::from_mode(0o600)).unwrap();
    let file = Whole::create(&folder.join("a")).unwrap();
    for name in folder.names() {
        assert_eq!(mode(&folder.join(&name)) & 0o077, 0, "{name}");
    }
    drop(file);
}

/// Root may write everything, so the test becomes another user.
#[test]
fn a_read_only_file_is_not_replaced() {
    let folder = Folder::new("read-only");
    let path = folder.join("a");
    fs::write(&path, "good").unwrap();
    fs::set_permissions(&path, Permissions::from_mode(0o444)).unwrap();
    fs::set_permissions(&folder.0, Permissions::from_mode(0o777)).unwrap();
    as_other(|| assert_eq!(why(write(&path, b"new")), "Permission denied"));
    assert_eq!((folder.read("a").as_str(), folder.names()), ("good", vec!["a".to_owned()]));
    // A file that may be written, in a folder that may not.
    fs::set_permissions(&path, Permissions::from_mode(0o666)).unwrap();
    fs::set_permissions(&folder.0, Permissions::from_mode(0o555)).unwrap();
    let want = "Permission denied: no file can be made beside it";
    as_other(|| assert_eq!(why(write(&path, b"new")), want));
    assert_eq!(folder.read("a"), "good");
    fs::set_permissions(&folder.0, Permissions::from_mode(0o755)).unwrap();
}

/// Runs a function in a thread that is not root.
fn as_other(work: impl FnOnce() + Send) {
    let become_other = || {
        if geteuid().is_root() {
            let (uid, gid) = (Uid::from_raw(60_001), Gid::from_raw(60_001));
            set_thread_groups(&[]).unwrap();
            set_thread_res_gid(gid, gid, gid).unwrap();
            set_thread_res_uid(uid, uid, uid).unwrap();
        }
        work();
    };
    std::thread::scope(|scope| scope.spawn(become_other).join().unwrap());
}

#[test]
fn a_growing_file_takes_its_place_with_its_first_records() {
    let folder = Folder::new("growing");
    let path = folder.join("a");
    fs::write(&path, "good").unwrap();
    drop(Growing::create(&path).unwrap());
    assert_eq!((folder.read("a").as_str(), folder.names().len()), ("good", 1));
    let mut file = Growing::create(&path).unwrap();
    assert!(!file.is_there());
    for (records, want) in [("one\n", "one\n"), ("two\n", "one\ntwo\n")] {
        file.append(records.as_bytes()).unwrap();
        assert_eq!((folder.read("a").as_str(), file.is_there()), (want, true));
    }
    assert_eq!(file.bytes(), 8);
    file.finish().unwrap();
    assert_eq!(folder.names(), ["a"]);
    // Its first records may be stored before.
    let mut file = Growing::create_stored(&path, b"three\n").unwrap();
    assert_eq!((folder.read("a").as_str(), file.bytes(), file.is_there()), ("three\n", 6, true));
    file.append(b"four\n").unwrap();
    assert_eq!((folder.read("a").as_str(), folder.names().len()), ("three\nfour\n", 1));
    // A file without records is empty.
    Growing::create(&path).unwrap().finish().unwrap();
    assert_eq!(folder.read("a"), "");
}
