//! Files that lie in wait under good names: links, hard links, pipes, executables, other files, and a race between check
//! and use; each for every operation, and by both ways of opening.

use crate::{
    Beneath, FileName, NewFile, OpenError, RelativeName, is_below,
    opening::{Way, by},
};
use rustix::{
    fs::{CWD, FileType, Mode, OFlags, mknodat},
    io::Errno,
};
use std::{
    fs,
    io::{Read as _, Write as _},
    os::unix::fs::{PermissionsExt as _, symlink},
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

/// Text of files that stay unread and unchanged.
const SECRET: &str = "secret";

/// Rounds of a race.
const ROUNDS: u32 = 300;

/// A folder `room` with traps in it, and beside it what they lead to.
struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let folder =
            std::env::temp_dir().join(format!("hal-beneath-{name}-{}", std::process::id()));
        fs::create_dir_all(folder.join("room/sub")).unwrap();
        fs::create_dir_all(folder.join("other")).unwrap();
        for file in ["secret", "other/file", "executable"] {
            fs::write(folder.join(file), SECRET).unwrap();
        }
        let at = |name: &str| folder.join("room").join(name);
        symlink("../secret", at("link")).unwrap();
        symlink(folder.join("secret"), at("whole")).unwrap();
        symlink("../new", at("dangling")).unwrap();
        symlink("link", at("twice")).unwrap();
        symlink("/proc/self/fd/0", at("magic")).unwrap();
        symlink("../other", at("folder")).unwrap();
        symlink("sub", at("inner")).unwrap();
        fs::hard_link(folder.join("secret"), at("hard")).unwrap();
        fs::write(at("run"), SECRET).unwrap();
        fs::set_permissions(at("run"), fs::Permissions::from_mode(0o755)).unwrap();
        mknodat(CWD, at("pipe"), FileType::Fifo, Mode::from_raw_mode(0o666), 0).unwrap();
        fs::write(at("sub/good"), "good").unwrap();
        fs::write(at("good"), "good").unwrap();
        Self(folder)
    }

    fn room(&self) -> Beneath {
        Beneath::open(&self.0.join("room")).unwrap()
    }

    /// Checks that nothing outside has changed.
    fn is_kept(&self) {
        for file in ["secret", "other/file", "room/run"] {
            assert_eq!(fs::read_to_string(self.0.join(file)).unwrap(), SECRET, "{file}");
        }
        assert!(!self.0.join("new").exists());
        assert_eq!(fs::read_dir(self.0.join("other")).unwrap().count(), 1);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap_or_default();
    }
}

fn name(text: &str) -> RelativeName {
    RelativeName::parse(text).unwrap()
}

/// Returns the kind of an error, in a word.
fn kind<T>(result: Result<T, OpenError>) -> &'static str {
    match result.map(drop) {
        Ok(()) => "ok",
        Err(OpenError::Name { .. }) => "name",
        Err(OpenError::Missing { .. }) => "missing",
        Err(OpenError::Link { .. }) => "link",
        Err(OpenError::HardLink { .. }) => "hard",
        Err(OpenError::NoFile { .. }) => "no-file",
        Err(OpenError::NoFolder { .. }) => "no-folder",
        Err(OpenError::Program { .. }) => "program",
        Err(OpenError::Owner { .. }) => "owner",
        Err(OpenError::Writable { .. }) => "writable",
        Err(OpenError::System { .. }) => "system",
    }
}

/// Traps, and what reading, reading alone, writing behind the end, replacing and removing say to each.
const TRAPS: &[(&str, [&str; 5])] = &[
    ("link", ["link", "link", "link", "link", "link"]),
    ("whole", ["link", "link", "link", "link", "link"]),
    ("dangling", ["link", "link", "link", "link", "link"]),
    ("twice", ["link", "link", "link", "link", "link"]),
    ("magic", ["link", "link", "link", "link", "link"]),
    ("folder/file", ["link", "link", "link", "link", "link"]),
    ("inner/good", ["link", "link", "link", "link", "link"]),
    ("hard", ["ok", "hard", "hard", "hard", "hard"]),
    ("run", ["ok", "ok", "program", "program", "program"]),
    ("pipe", ["no-file", "no-file", "no-file", "no-file", "no-file"]),
    ("sub", ["no-file", "no-file", "no-file", "no-file", "no-file"]),
    ("none", ["missing", "missing", "ok", "ok", "missing"]),
    ("good", ["ok", "ok", "ok", "ok", "ok"]),
    ("sub/good", ["ok", "ok", "ok", "ok", "ok"]),
];

#[test]
fn each_operation_meets_each_trap() {
    let said = |trap: &str| {
        // Each operation has a new folder: some remove what is there.
        let of = |n: usize| {
            let place = Place::new("traps");
            let (room, file) = (place.room(), name(trap));
            let folder = || room.folder_of(&file, false);
            let said = match n {
                0 => kind(room.read(&file)),
                1 => kind(room.read_sole(&file)),
                2 => kind(room.append(&file).map(|mut open| open.write_all(b"x").unwrap())),
                3 => kind(folder().and_then(|folder| {
                    let mut new = folder.replace(file.file())?;
                    new.write_all(b"x").unwrap();
                    new.finish()
                })),
                _ => kind(folder().and_then(|folder| folder.remove(file.file()))),
            };
            place.is_kept();
            said
        };
        [0, 1, 2, 3, 4].map(of)
    };
    for (trap, wanted) in TRAPS {
        assert_eq!(said(trap), *wanted, "{trap}");
    }
}

#[test]
fn both_ways_of_opening_agree() {
    let place = Place::new("ways");
    let (room, mut whole) = (place.room(), 0);
    for (trap, _) in TRAPS {
        let open = |way| {
            let flags = OFlags::RDONLY | OFlags::NONBLOCK;
            let opened = by(way, &room, &name(trap), flags, Mode::empty()).map(drop);
            // A link in the place of a folder: one way says that it is a link, the other that it is no folder.
            opened.map_err(|e| if e == Errno::NOTDIR { Errno::LOOP } else { e })
        };
        let (by_system, by_parts) = (open(Way::Whole), open(Way::Parts));
        whole += u32::from(by_system != Err(Errno::NOSYS));
        assert!(
            [Err(Errno::NOSYS), by_parts].contains(&by_system),
            "{trap}: {by_system:?} {by_parts:?}"
        );
        let is_link = ["link", "whole", "dangling", "twice", "magic", "folder/file", "inner/good"]
            .contains(trap);
        assert_eq!(by_parts == Err(Errno::LOOP), is_link, "{trap}: {by_parts:?}");
    }
    // A system has the call, or it has it not.
    assert!(whole == 0 || whole as usize == TRAPS.len());
}

#[test]
fn a_folder_that_is_moved_away_stays_the_one_that_was_opened() {
    let place = Place::new("moved");
    let room = place.room();
    fs::rename(place.0.join("room"), place.0.join("away")).unwrap();
    symlink("other", place.0.join("room")).unwrap();
    let mut new = room.replace(&FileName::parse("file").unwrap()).unwrap();
    new.write_all(b"mine").unwrap();
    new.finish().unwrap();
    assert_eq!(fs::read_to_string(place.0.join("away/file")).unwrap(), "mine");
    assert_eq!(fs::read_to_string(place.0.join("other/file")).unwrap(), SECRET);
}

/// Sets a flag at its end, also after a panic: the threads that wait for it end.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        // Relaxed: the flag guards nothing.
        self.0.store(true, Relaxed);
    }
}

#[test]
fn a_race_of_file_and_link_opens_the_file_or_nothing() {
    let place = Place::new("race");
    let (room, ends) = (place.room(), AtomicBool::new(false));
    let at = |name: &str| place.0.join("room").join(name);
    std::thread::scope(|scope| {
        // Files and folders change places with links, again and again. Steps may fail, as in a race.
        scope.spawn(|| {
            while !ends.load(Relaxed) {
                fs::write(at("next"), "good").unwrap_or_default();
                fs::rename(at("next"), at("race")).unwrap_or_default();
                symlink("../secret", at("swap")).unwrap_or_default();
                fs::rename(at("swap"), at("race")).unwrap_or_default();
                fs::remove_file(at("deep")).unwrap_or_default();
                fs::create_dir(at("deep")).unwrap_or_default();
                fs::write(at("deep/file"), "good").unwrap_or_default();
                fs::remove_dir_all(at("deep")).unwrap_or_default();
                symlink("../other", at("deep")).unwrap_or_default();
            }
        });
        let _ends = Ends(&ends);
        for round in 0..ROUNDS {
            for trap in ["race", "deep/file"] {
                if let Ok(mut file) = room.read(&name(trap)) {
                    let mut text = String::new();
                    file.read_to_string(&mut text).unwrap();
                    assert_ne!(text, SECRET, "{trap} {round}");
                }
                // Either the file is written, or nothing is.
                drop(room.append(&name(trap)).map(|mut file| file.write_all(b"x").unwrap()));
            }
            let mut new = room.replace(&FileName::parse("race").unwrap());
            if let Ok(new) = &mut new {
                new.write_all(b"good").unwrap();
            }
            drop(new.and_then(NewFile::finish));
        }
    });
    place.is_kept();
}

#[test]
fn a_new_file_has_the_rights_of_the_old_one_and_leaves_nothing() {
    let place = Place::new("rights");
    let (room, good) = (place.room(), FileName::parse("good").unwrap());
    let path = place.0.join("room/good");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
    let mut new = room.replace(&good).unwrap();
    new.write_all(b"new").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "good", "the old file stays until then");
    new.finish().unwrap();
    let mode = fs::metadata(&path).unwrap().permissions().mode() & 0o7777;
    assert_eq!((fs::read_to_string(&path).unwrap().as_str(), mode), ("new", 0o600));
    drop(room.replace(&good).unwrap());
    let left = fs::read_dir(place.0.join("room")).unwrap();
    let left =
        left.filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().starts_with('.'));
    assert_eq!(left.count(), 0);
}

#[test]
fn a_list_shows_files_alone_and_is_bounded() {
    let place = Place::new("list");
    let names = |depth, most| {
        let list = place.room().list(depth, most).unwrap();
        list.into_iter().map(|found| found.name.into_string()).collect::<Vec<_>>()
    };
    fs::write(place.0.join("room/.hidden"), "").unwrap();
    fs::write(place.0.join("room/cafe\u{301}"), "").unwrap();
    assert_eq!(names(1, 100), ["good", "hard", "run", "sub/good"]);
    assert_eq!(names(0, 100), ["good", "hard", "run"]);
    assert!(names(1, 3).len() <= 3);
}

#[test]
fn a_path_is_below_a_folder_wherever_links_lead() {
    let place = Place::new("below");
    let below = |path: &str, folder: &str| is_below(&place.0.join(path), &place.0.join(folder));
    assert!(below("room/folder/file", "other") && below("room/folder/none/x", "other"));
    assert!(below("other/../room/good", "room") && below("none/../room", "room"));
    assert!(!below("other/file", "room") && !below("roommate", "room"));
    assert!(is_below(Path::new("/"), Path::new("/")));
}
