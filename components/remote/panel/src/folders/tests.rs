//! Names in requests, and what they reach.

use super::{Code, Folders, whole};
use std::{
    fs,
    io::Write as _,
    os::unix::fs::{PermissionsExt as _, symlink},
    path::PathBuf,
};

impl Folders {
    /// Returns those of one folder of programs.
    pub(crate) fn of(programs: PathBuf) -> Self {
        Self { programs: Some(programs), ..Self::default() }
    }
}

struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("halpanel-{name}-{}", std::process::id()));
        fs::create_dir_all(folder.join("programs/uploads")).unwrap();
        fs::write(folder.join("people"), "kept").unwrap();
        fs::write(folder.join("programs/part.ngc"), "owner").unwrap();
        Self(folder)
    }

    fn folders(&self) -> Folders {
        Folders::of(self.0.join("programs"))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap_or_default();
    }
}

/// Stores a text under a name, and returns the code of the refusal.
fn put(folders: &Folders, name: &str) -> Option<Code> {
    let stored = folders.upload(name).and_then(|file| {
        let mut new = file.create()?;
        new.write_all(b"sent").unwrap();
        new.finish().map_err(super::refused)
    });
    stored.err().map(|why| why.code)
}

#[test]
fn an_upload_goes_to_its_folder_and_nowhere_else() {
    let place = Place::new("uploads");
    let (folders, programs) = (place.folders(), place.0.join("programs"));
    let uploads = programs.join("uploads");
    fs::write(uploads.join("run.ngc"), "kept").unwrap();
    fs::set_permissions(uploads.join("run.ngc"), fs::Permissions::from_mode(0o755)).unwrap();
    symlink(place.0.join("people"), uploads.join("link.ngc")).unwrap();
    symlink(place.0.join("new"), uploads.join("new.ngc")).unwrap();
    fs::hard_link(place.0.join("people"), uploads.join("hard.ngc")).unwrap();
    fs::create_dir(uploads.join("folder.ngc")).unwrap();
    for (name, code) in [
        ("M101", Code::Malformed),
        ("a.py", Code::Malformed),
        ("a.hal", Code::Malformed),
        ("a.ini", Code::Malformed),
        ("people", Code::Malformed),
        (".a.ngc", Code::Malformed),
        ("../a.ngc", Code::Malformed),
        ("uploads/../a.ngc", Code::Malformed),
        ("uploads/b/a.ngc", Code::Malformed),
        ("/tmp/a.ngc", Code::Malformed),
        ("a\0.ngc", Code::Malformed),
        ("a\u{301}.ngc", Code::Malformed),
        ("\u{ff2d}.ngc", Code::Malformed),
        ("", Code::Malformed),
        (&*format!("{}.ngc", "a".repeat(252)), Code::Malformed),
        ("part.ngc", Code::Conflict),
        ("run.ngc", Code::Conflict),
        ("link.ngc", Code::Conflict),
        ("new.ngc", Code::Conflict),
        ("hard.ngc", Code::Conflict),
        ("folder.ngc", Code::Conflict),
    ] {
        assert_eq!(put(&folders, name), Some(code), "{name:?}");
    }
    for name in ["a.ngc", "uploads/a.ngc", "uploads/part.ngc", "Teil 1.TAP"] {
        assert_eq!(put(&folders, name), None, "{name}");
    }
    for name in ["a.ngc", "part.ngc", "Teil 1.TAP"] {
        let mode = fs::metadata(uploads.join(name)).unwrap().permissions().mode();
        assert_eq!(mode & 0o111, 0, "{name}");
    }
    let text = |name: &str| whole(folders.program(name).unwrap().open().unwrap(), 99).unwrap();
    assert_eq!((text("part.ngc"), text("uploads/part.ngc")), (b"owner".to_vec(), b"sent".to_vec()));
    assert_eq!(text("a.ngc"), b"sent");
    for name in ["link.ngc", "uploads/hard.ngc", "folder.ngc"] {
        assert_eq!(folders.program(name).unwrap().open().unwrap_err().code, Code::Conflict);
        assert_eq!(folders.upload(name).unwrap().remove().unwrap_err().code, Code::Conflict);
    }
    let list: Vec<_> = folders.programs().unwrap().into_iter().map(|found| found.name).collect();
    let wanted = ["part.ngc", "uploads/Teil 1.TAP", "uploads/a.ngc", "uploads/hard.ngc"];
    assert_eq!(list.iter().map(|n| &**n).take(4).collect::<Vec<_>>(), wanted);
    assert_eq!(fs::read_to_string(place.0.join("people")).unwrap(), "kept");
    assert_eq!(fs::read_to_string(programs.join("part.ngc")).unwrap(), "owner");
    assert!(!place.0.join("new").exists());
    folders.upload("a.ngc").unwrap().remove().unwrap();
    assert_eq!(folders.program("a.ngc").unwrap().open().unwrap_err().code, Code::NotFound);
}

#[test]
fn a_folder_of_uploads_that_is_a_link_is_not_used() {
    let place = Place::new("linked");
    let uploads = place.0.join("programs/uploads");
    fs::remove_dir(&uploads).unwrap();
    fs::create_dir(place.0.join("codes")).unwrap();
    symlink(place.0.join("codes"), &uploads).unwrap();
    assert_eq!(put(&place.folders(), "a.ngc"), Some(Code::Conflict));
    assert!(!place.0.join("codes/a.ngc").exists());
}

#[test]
fn a_folder_of_programs_that_is_not_there_is_named_with_what_would_be_right() {
    let place = Place::new("absent");
    let folders = Folders {
        programs: Some(place.0.join("of-another-computer")),
        absent: Some("write PROGRAM_PREFIX = nc_files".into()),
        ..Folders::default()
    };
    let said = folders.programs().unwrap_err();
    let want = format!(
        "{}/of-another-computer, the folder of programs ([DISPLAY]PROGRAM_PREFIX), is not there: \
         write PROGRAM_PREFIX = nc_files",
        place.0.display()
    );
    assert_eq!((said.code, &*said.text), (Code::NotFound, &*want));
    // Once it is there, it is used.
    fs::create_dir(place.0.join("of-another-computer")).unwrap();
    assert!(folders.programs().unwrap().is_empty());
}
