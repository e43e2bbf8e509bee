//! Files on the plugin path: their kind, their description of themselves, and whether root may open
//! them. No code of a file runs here.

use crate::{
    PluginError,
    load::elf::{Elf, Parts},
    os,
};
use hal_abi::names;
use rustix::{
    fs::{FileType, Mode, OFlags, Stat},
    io::Errno,
};
use std::{
    collections::BTreeSet,
    fs::File,
    os::{fd::AsRawFd, unix::fs::MetadataExt},
    path::{Path, PathBuf},
};

/// The bits of a mode that let the group or others write.
const OTHERS_WRITE: u32 = 0o022;

/// A regular file.
#[derive(Debug)]
pub(crate) struct PluginFile {
    path: PathBuf,
    file: File,
    stat: Stat,
}

/// Identity of a file at some time: the file, and its last change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Identity {
    device: u64,
    inode: u64,
    size: i64,
    changed: (i64, i64),
}

/// Contents that a plugin library declares.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Names {
    /// Component types.
    pub(crate) components: BTreeSet<String>,
    /// Symbols by which the library's loaders recognise their files.
    pub(crate) loaders: BTreeSet<String>,
    /// Release of Ferrule that the library is part of; absent in a library of somebody else's.
    pub(crate) release: Option<String>,
}

/// Release of this engine.
const RELEASE: &str = env!("CARGO_PKG_VERSION");

/// A plugin library, before it is opened.
#[derive(Debug)]
pub(crate) struct Described {
    /// The symbol of its descriptor.
    pub(crate) symbol: String,
    /// Declared contents; absent in a library that was built before names existed.
    pub(crate) names: Option<Names>,
}

impl PluginFile {
    /// Examines a path; returns `None` if nothing is there. Opens for reading only a regular file:
    /// a pipe would block, and opening a device may have effects.
    pub(crate) fn find(path: &Path) -> Result<Option<Self>, PluginError> {
        let not = |e: Errno| not(path, &os::said(&e.into()));
        let irregular = |what| PluginError::Irregular { file: shown(path), what };
        let flags = OFlags::PATH | OFlags::CLOEXEC;
        let found = match rustix::fs::open(path, flags, Mode::empty()) {
            Ok(found) => found,
            Err(Errno::NOENT | Errno::NOTDIR) if !path.is_symlink() => return Ok(None),
            Err(Errno::NOENT | Errno::NOTDIR) => {
                return Err(irregular("a symbolic link to nothing"));
            }
            Err(Errno::LOOP) => return Err(irregular("a symbolic link to itself")),
            Err(e) => return Err(not(e)),
        };
        let stat = rustix::fs::fstat(&found).map_err(not)?;
        match FileType::from_raw_mode(stat.st_mode) {
            FileType::RegularFile => {}
            FileType::Directory => return Err(irregular("a folder")),
            FileType::Fifo => return Err(irregular("a named pipe")),
            FileType::Socket => return Err(irregular("a socket")),
            _ => return Err(irregular("a device")),
        }
        // Reopened through the examined descriptor, so that it is the very same file.
        let through = Path::new("/proc/self/fd").join(found.as_raw_fd().to_string());
        let flags = OFlags::RDONLY | OFlags::CLOEXEC;
        let file = rustix::fs::open(through, flags, Mode::empty()).map_err(not)?.into();
        Ok(Some(Self { path: path.to_owned(), file, stat }))
    }

    /// Returns the path at which the file was found.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the identity of the file.
    pub(crate) fn identity(&self) -> Identity {
        let changed = (self.stat.st_ctime, i64::try_from(self.stat.st_ctime_nsec).unwrap_or(0));
        let Stat { st_dev: device, st_ino: inode, st_size: size, .. } = self.stat;
        Identity { device, inode, size, changed }
    }

    /// Reads the file's description of itself, if it is a plugin library; the file's name
    /// determines the symbols.
    pub(crate) fn describe(&self) -> Result<Described, PluginError> {
        let stem = self.path.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
        let stem = stem.strip_prefix("lib").unwrap_or(stem).replace('-', "_");
        let symbol = format!("hal_library_{stem}");
        let parts = Parts::new(&self.file);
        let elf = Elf::read(&parts).map_err(|why| not(&self.path, why))?;
        if !elf.fits() {
            return Err(not(&self.path, "it is built for another kind of machine"));
        }
        if !elf.exports(&symbol) {
            let why = format!("it exports no '{symbol}' (was the file renamed?)");
            return Err(not(&self.path, &why));
        }
        let bytes = elf.bytes(&format!("hal_names_{stem}"), names::MAX_LEN);
        Ok(Described { symbol, names: bytes.and_then(Names::parse) })
    }

    /// Returns the first of these symbols that the file exports.
    pub(crate) fn exported<'s>(&self, symbols: impl Iterator<Item = &'s str>) -> Option<&'s str> {
        let parts = Parts::new(&self.file);
        let elf = Elf::read(&parts).ok()?;
        let mut symbols = symbols;
        symbols.find(|symbol| elf.exports(symbol))
    }

    /// Returns the path, without links, by which the library is opened, if this user may open it.
    /// Root opens only files that other users cannot have put there.
    pub(crate) fn openable(&self) -> Result<PathBuf, PluginError> {
        let path = self.path.canonicalize().map_err(|e| not(&self.path, &os::said(&e)))?;
        if rustix::process::geteuid().is_root() {
            let trusted = Trusted::of(&self.path);
            trusted.check(&path, self.stat.st_uid, self.stat.st_mode)?;
            // Both the real file's folder and the folder in which the file was found.
            for folder in [path.parent(), self.path.parent()].into_iter().flatten() {
                let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
                let m = folder.metadata().map_err(|e| not(&self.path, &os::said(&e)))?;
                trusted.check(folder, m.uid(), m.mode())?;
            }
        }
        Ok(path)
    }
}

impl Described {
    /// Refuses a library of another release of Ferrule: it is made for the engine and the plugins of that release, and
    /// lies where this engine's own lay when the machine began.
    pub(crate) fn permit(&self, path: &Path) -> Result<(), PluginError> {
        match self.names.as_ref().and_then(|names| names.release.as_deref()) {
            Some(has) if has != RELEASE => {
                Err(PluginError::OtherRelease { file: shown(path), has: has.into(), runs: RELEASE })
            }
            _ => Ok(()),
        }
    }
}

impl Names {
    fn parse(bytes: &[u8]) -> Option<Self> {
        let mut out = Self::default();
        for (letter, name) in names::parse(bytes)? {
            match letter {
                names::COMPONENT => out.components.insert(name.to_owned()),
                names::LOADER => out.loaders.insert(name.to_owned()),
                names::RELEASE => out.release.replace(name.to_owned()).is_none(),
                // A kind of a later minor version.
                _ => false,
            };
        }
        Some(out)
    }
}

/// The owners whose files root opens.
#[derive(Debug)]
struct Trusted<'f> {
    file: &'f Path,
    /// The user who became root by `sudo`.
    caller: Option<u32>,
}

impl<'f> Trusted<'f> {
    fn of(file: &'f Path) -> Self {
        // In a set-user-ID program, the calling user controls the environment.
        let is_root = rustix::process::getuid().is_root();
        let caller = std::env::var("SUDO_UID").ok().filter(|_| is_root);
        Self { file, caller: caller.and_then(|uid| uid.parse().ok()) }
    }

    fn check(&self, path: &Path, owner: u32, mode: u32) -> Result<(), PluginError> {
        let file = shown(self.file);
        if owner != 0 && self.caller != Some(owner) {
            return Err(PluginError::Owner { file, path: shown(path), owner });
        }
        let mode = mode & 0o7777;
        if mode & OTHERS_WRITE != 0 {
            return Err(PluginError::Writable { file, path: shown(path), mode });
        }
        Ok(())
    }
}

fn shown(path: &Path) -> Box<str> {
    path.display().to_string().into()
}

fn not(path: &Path, why: &str) -> PluginError {
    PluginError::NotAPlugin { file: shown(path), why: why.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        const KINDS: &[(u8, &[&str])] =
            &[(names::COMPONENT, &["and2", "or2", "\u{e4}"]), (names::LOADER, &["rtapi_app_main"])];
        const BYTES: [u8; names::len(KINDS)] = names::bytes(KINDS);
        assert_eq!(&BYTES, "hal-names 1\0cand2\0cor2\0c\u{e4}\0lrtapi_app_main\0".as_bytes());
        let set = |all: &[&str]| all.iter().map(|n| (*n).to_owned()).collect::<BTreeSet<String>>();
        let read = Names::parse(&BYTES).unwrap();
        assert_eq!(read.components, set(&["and2", "or2", "\u{e4}"]));
        assert_eq!(read.loaders, set(&["rtapi_app_main"]));
        assert_eq!(read.release, None);
        let of = |names: &[u8]| Described { symbol: String::new(), names: Names::parse(names) };
        let permit = |names: &[u8]| of(names).permit(Path::new("x.so")).map_err(|e| e.to_string());
        let own = format!("hal-names 1\0ca\0v{RELEASE}\0");
        assert_eq!(
            (permit(&BYTES), permit(own.as_bytes()), permit(b"\0")),
            (Ok(()), Ok(()), Ok(()))
        );
        let want = format!(
            "x.so: part of Ferrule 9.8, and this instance runs {RELEASE}: restart the machine, which then uses 9.8"
        );
        assert_eq!(permit(b"hal-names 1\0ca\0v9.8\0"), Err(want));
        for (bytes, want) in [
            (&b"hal-names 1\0"[..], Some(0)),
            (b"hal-names 1\0ca\0xlater\0\0cb\0", Some(2)),
            (b"hal-names 1\0c\xff\xfe\0ca\0", Some(1)),
            (b"hal-names 1", None),
            (b"hal-names 1\0ca", None),
            (b"hal-names 2\0ca\0", None),
            (b"\0", None),
            (b"", None),
        ] {
            let read = Names::parse(bytes).map(|n| n.components.len());
            assert_eq!(read, want, "{}", String::from_utf8_lossy(bytes));
        }
    }

    fn identity(path: &Path) -> Identity {
        PluginFile::find(path).unwrap().unwrap().identity()
    }

    #[test]
    fn a_file_that_has_changed_is_another_and_so_is_each_of_two() {
        let folder = std::env::temp_dir().join(format!("hal-identity-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.join(name));
        std::fs::write(&a, "good").unwrap();
        let before = identity(&a);
        assert_eq!(identity(&a), before);
        // The same file, just as long; the system's time of a change has steps.
        let changed = |path: &Path| {
            let m = path.metadata().unwrap();
            (m.ctime(), m.ctime_nsec())
        };
        let first = changed(&a);
        while changed(&a) == first {
            std::fs::write(&a, "evil").unwrap();
        }
        assert_ne!(identity(&a), before);
        // Two files, just as long, as if they were changed at the same time.
        std::fs::write(&b, "good").unwrap();
        let at_once = |path| Identity { changed: (0, 0), ..identity(path) };
        assert_ne!(at_once(&a), at_once(&b));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
