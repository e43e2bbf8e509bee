//! The folder with the files of a user's instances. It is checked, held open, and accessed only
//! through the open descriptor, so that nobody can replace it between the check and the use.

use crate::{Failure, Place, peer};
use rustix::{
    fs::{AtFlags, FileType, FlockOperation, Mode, OFlags, Stat},
    io::Errno,
    net::{AddressFamily, SocketAddrUnix, SocketFlags, SocketType},
    time::Timespec,
};
use std::{
    fs::{DirBuilder, File},
    os::{
        fd::{AsRawFd, OwnedFd},
        unix::{
            fs::DirBuilderExt,
            net::{UnixListener, UnixStream},
        },
    },
    path::{Path, PathBuf},
};

/// User id of root.
const ROOT: u32 = 0;
/// Mode bits that let the group or others write.
const OTHERS_WRITE: u32 = 0o022;
/// Mode bits of the group and of others.
const OTHERS_USE: u32 = 0o077;
/// Bits of the folder of a system service, for the service's group.
const SERVICE_GROUP: u32 = 0o050;
/// First user id of a person; below it are root and the users of system services.
const FIRST_PERSON: u32 = 1000;
/// The number of times that a lock is tried again, and the nanoseconds between: half a second.
const LOCK_TRIES: u32 = 100;
const LOCK_WAIT_NS: i64 = 5_000_000;
/// The length in bytes from which a log is emptied.
const MAX_LOG: i64 = 1 << 20;

/// Reason why the files of an instance are not used.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the sentence of each variant is its documentation")]
pub enum FolderError {
    Missing { path: Box<Path> },
    Link { path: Box<Path> },
    NoFolder { path: Box<Path> },
    Owner { path: Box<Path>, owner: u32, expected: u32 },
    Writable { path: Box<Path>, mode: u32 },
    NoSocket { path: Box<Path> },
    Peer { path: Box<Path>, peer: u32, expected: u32 },
    Taken { instance: Box<str> },
    System { path: Box<Path>, why: Box<str> },
}

impl core::fmt::Display for FolderError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Missing { path } => write!(f, "{}: there is no such folder", path.display()),
            Self::Link { path } => {
                write!(f, "{} is a symbolic link, which leads anywhere", path.display())
            }
            Self::NoFolder { path } => write!(f, "{} is not a folder", path.display()),
            Self::Owner { path, owner, expected } => {
                write!(f, "{} belongs to user {owner}, not to user {expected}", path.display())
            }
            Self::Writable { path, mode } => {
                write!(f, "{} can be written by other users (mode {mode:04o})", path.display())
            }
            Self::NoSocket { path } => write!(f, "{} is not a socket", path.display()),
            Self::Peer { path, peer, expected } => write!(
                f,
                "the engine at {} runs as user {peer}, not as user {expected}",
                path.display()
            ),
            Self::Taken { instance } => write!(f, "instance '{instance}' is already running"),
            Self::System { path, why } => write!(f, "{}: {why}", path.display()),
        }
    }
}

impl std::error::Error for FolderError {}

impl FolderError {
    /// Returns the suggested correction.
    fn hint(&self) -> Option<String> {
        let own = "name a folder of this user's own in HAL_RUNTIME_DIR";
        match self {
            Self::Link { .. } | Self::NoFolder { .. } | Self::NoSocket { .. } => {
                Some(format!("remove it, or {own}"))
            }
            Self::Owner { .. } => Some(own.to_owned()),
            Self::Writable { path, .. } => {
                Some(format!("run 'chmod go-w {}', or {own}", path.display()))
            }
            Self::Missing { .. } | Self::Peer { .. } | Self::Taken { .. } | Self::System { .. } => {
                None
            }
        }
    }
}

impl From<FolderError> for Failure {
    fn from(error: FolderError) -> Self {
        let errno = match &error {
            FolderError::Missing { .. } => Errno::NOENT,
            FolderError::Taken { .. } => Errno::BUSY,
            FolderError::System { .. } => Errno::IO,
            _ => Errno::ACCESS,
        };
        let mut failure = Self::new(-errno.raw_os_error(), error.to_string());
        failure.hint = error.hint();
        failure
    }
}

/// An open, checked folder of instances.
#[derive(Debug)]
pub struct Folder {
    fd: OwnedFd,
    path: PathBuf,
    owner: u32,
    /// The group that a system service lets in.
    group: Option<u32>,
}

impl Folder {
    /// Opens the folder of one of this user's instances. Root may also open another user's folder
    /// if it was named explicitly ([`Place::is_named`]), and so may anybody whom a system service's folder lets in: its
    /// mode is 0750, and the kernel lets only the service's group pass.
    ///
    /// # Errors
    /// The folder does not exist, or another user could have made it or can change it.
    pub fn open(place: &Place) -> Result<Self, FolderError> {
        let me = rustix::process::geteuid().as_raw();
        let any_user = me == ROOT && place.is_named();
        Self::checked(place.folder(), |stat| {
            let is_let_in = place.is_named() && is_of_service(stat);
            if any_user || is_let_in { stat.st_uid } else { me }
        })
    }

    /// Opens the folder of this user's instances and creates it if needed. Nobody else reaches what is in it: bits of
    /// others are taken away, but for those of a system service's group (mode 0750).
    ///
    /// # Errors
    /// As [`Self::open`], or the folder cannot be created.
    pub fn make(place: &Place) -> Result<Self, FolderError> {
        let path = place.folder();
        let made = DirBuilder::new().recursive(true).mode(0o700).create(path);
        let me = rustix::process::geteuid().as_raw();
        match (Self::checked(path, |_| me), made) {
            (Err(FolderError::Missing { .. }), Err(e)) => {
                Err(FolderError::System { path: path.into(), why: reason(&e) })
            }
            (opened, _) => {
                let opened = opened?;
                opened.close_to_others();
                Ok(opened)
            }
        }
    }

    /// Takes the bits of others away from the mode of the folder.
    fn close_to_others(&self) {
        let Ok(stat) = rustix::fs::fstat(&self.fd) else { return };
        let mode = stat.st_mode & 0o7777;
        if mode & OTHERS_USE != 0 && !is_of_service(&stat) {
            let own = Mode::from_raw_mode(mode & !OTHERS_USE);
            // Through the open folder, whatever has its name now. Some file systems have no permissions.
            let path = Path::new("/proc/self/fd").join(self.fd.as_raw_fd().to_string());
            rustix::fs::chmod(&path, own).unwrap_or_default();
        }
    }

    fn checked(path: &Path, expected: impl Fn(&Stat) -> u32) -> Result<Self, FolderError> {
        let flags = OFlags::PATH | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let fd = rustix::fs::open(path, flags, Mode::empty()).map_err(|e| match e {
            Errno::NOENT => FolderError::Missing { path: path.into() },
            Errno::NOTDIR | Errno::LOOP if path.is_symlink() => {
                FolderError::Link { path: path.into() }
            }
            Errno::NOTDIR => FolderError::NoFolder { path: path.into() },
            e => FolderError::System { path: path.into(), why: reason(&e.into()) },
        })?;
        let stat = rustix::fs::fstat(&fd)
            .map_err(|e| FolderError::System { path: path.into(), why: reason(&e.into()) })?;
        let expected = expected(&stat);
        if stat.st_uid != expected {
            return Err(FolderError::Owner { path: path.into(), owner: stat.st_uid, expected });
        }
        let mode = stat.st_mode & 0o7777;
        if mode & OTHERS_WRITE != 0 {
            return Err(FolderError::Writable { path: path.into(), mode });
        }
        let group = is_of_service(&stat).then_some(stat.st_gid);
        Ok(Self { fd, path: path.to_owned(), owner: stat.st_uid, group })
    }

    /// Connects to the engine of an instance. Returns `None` if nothing listens.
    ///
    /// # Errors
    /// The file is not a socket owned by the folder's owner, or another user listens at it.
    pub fn connect(&self, place: &Place) -> Result<Option<UnixStream>, FolderError> {
        let name = place.socket_name();
        match self.stat(&name)? {
            None => return Ok(None),
            Some(stat) => self.own(&name, &stat, FileType::Socket)?,
        }
        let socket = match UnixStream::connect(self.through(&name)) {
            Ok(socket) => socket,
            Err(e) => match e.kind() {
                std::io::ErrorKind::ConnectionRefused | std::io::ErrorKind::NotFound => {
                    return Ok(None);
                }
                _ => return Err(self.system(&name, &e)),
            },
        };
        let peer = peer(&socket).map_err(|e| self.system(&name, &e))?;
        if peer != self.owner {
            let path = self.path.join(&name).into();
            return Err(FolderError::Peer { path, peer, expected: self.owner });
        }
        Ok(Some(socket))
    }

    /// Acquires the lock file of the instance. A running engine holds this lock. Others hold it
    /// for a moment: a process that is being killed, the watcher that removes its files, a program
    /// that looks whether the instance has ended.
    ///
    /// # Errors
    /// The instance is already running, or the lock file cannot be created.
    pub fn lock(&self, place: &Place) -> Result<File, FolderError> {
        let name = place.lock_name();
        let flags = OFlags::CREATE | OFlags::RDWR | OFlags::NOFOLLOW | OFlags::NONBLOCK;
        let mut tries = 0;
        loop {
            let opened = rustix::fs::openat(
                &self.fd,
                &*name,
                flags | OFlags::CLOEXEC,
                Mode::RUSR | Mode::WUSR,
            );
            let fd = opened.map_err(|e| self.system(&name, &e.into()))?;
            let stat = rustix::fs::fstat(&fd).map_err(|e| self.system(&name, &e.into()))?;
            self.own(&name, &stat, FileType::RegularFile)?;
            if rustix::fs::flock(&fd, FlockOperation::NonBlockingLockExclusive).is_err() {
                if tries == LOCK_TRIES {
                    return Err(FolderError::Taken { instance: place.name().into() });
                }
                tries += 1;
                let time = Timespec { tv_sec: 0, tv_nsec: LOCK_WAIT_NS };
                // A signal makes the wait shorter.
                let _ = rustix::thread::nanosleep(&time);
                continue;
            }
            // The previous owner may have ended in the meantime and removed the file. A lock on a
            // removed file protects nothing, so try again.
            if self.stat(&name)?.is_some_and(|now| now.st_ino == stat.st_ino) {
                return Ok(fd.into());
            }
        }
    }

    /// Opens the file for what an instance in the background says, to add to it. A long file is
    /// emptied first.
    ///
    /// # Errors
    /// What is there is not a file of this user's, or the system refuses.
    pub fn log(&self, place: &Place) -> Result<File, FolderError> {
        let name = place.log_name();
        let flags = OFlags::CREATE | OFlags::WRONLY | OFlags::APPEND | OFlags::NOFOLLOW;
        let flags = flags | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let opened = rustix::fs::openat(&self.fd, &*name, flags, Mode::RUSR | Mode::WUSR);
        let fd = opened.map_err(|e| self.system(&name, &e.into()))?;
        let stat = rustix::fs::fstat(&fd).map_err(|e| self.system(&name, &e.into()))?;
        self.own(&name, &stat, FileType::RegularFile)?;
        if stat.st_size > MAX_LOG {
            rustix::fs::ftruncate(&fd, 0).map_err(|e| self.system(&name, &e.into()))?;
        }
        Ok(fd.into())
    }

    /// Returns whether no process holds the instance's lock.
    #[must_use]
    pub fn is_free(&self, place: &Place) -> bool {
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        match rustix::fs::openat(&self.fd, &*place.lock_name(), flags, Mode::empty()) {
            Ok(fd) => rustix::fs::flock(&fd, FlockOperation::NonBlockingLockShared).is_ok(),
            Err(e) => e == Errno::NOENT,
        }
    }

    /// Returns whether users of a system service's group can reach the socket.
    #[must_use]
    pub const fn lets_in_a_group(&self) -> bool {
        self.group.is_some()
    }

    /// Listens at the instance's socket, which only its user can reach, and the group of a system service's folder
    /// (mode 0660). The caller must hold the lock. Removes a socket that a dead engine left behind.
    ///
    /// # Errors
    /// A system call failed.
    pub fn listen(&self, place: &Place) -> Result<UnixListener, FolderError> {
        let name = place.socket_name();
        let system = |e: Errno| self.system(&name, &e.into());
        match rustix::fs::unlinkat(&self.fd, &*name, AtFlags::empty()) {
            Ok(()) | Err(Errno::NOENT) => {}
            Err(e) => return Err(system(e)),
        }
        let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
        let socket = rustix::net::socket_with(AddressFamily::UNIX, SocketType::STREAM, flags, None);
        let socket = socket.map_err(system)?;
        let mode = Mode::RUSR | Mode::WUSR;
        // The socket file is created with this mode, so other users cannot reach it at any moment.
        rustix::fs::fchmod(&socket, mode).map_err(system)?;
        let address = SocketAddrUnix::new(self.through(&name)).map_err(system)?;
        rustix::net::bind(&socket, &address).map_err(system)?;
        rustix::fs::chmodat(&self.fd, &*name, mode, AtFlags::empty()).map_err(system)?;
        if let Some(group) = self.group {
            let group = Some(rustix::fs::Gid::from_raw(group));
            rustix::fs::chownat(&self.fd, &*name, None, group, AtFlags::SYMLINK_NOFOLLOW)
                .map_err(system)?;
            let mode = mode | Mode::RGRP | Mode::WGRP;
            rustix::fs::chmodat(&self.fd, &*name, mode, AtFlags::empty()).map_err(system)?;
        }
        rustix::net::listen(&socket, 128).map_err(system)?;
        Ok(socket.into())
    }

    /// Removes the files of an instance that ends. Files that no longer exist are ignored.
    pub fn remove(&self, place: &Place) {
        for name in [place.socket_name(), place.lock_name()] {
            rustix::fs::unlinkat(&self.fd, &*name, AtFlags::empty()).unwrap_or_default();
        }
    }

    /// Returns a path that leads through the open folder, even if the folder has been moved.
    fn through(&self, name: &str) -> PathBuf {
        Path::new("/proc/self/fd").join(self.fd.as_raw_fd().to_string()).join(name)
    }

    fn stat(&self, name: &str) -> Result<Option<Stat>, FolderError> {
        match rustix::fs::statat(&self.fd, name, AtFlags::SYMLINK_NOFOLLOW) {
            Ok(stat) => Ok(Some(stat)),
            Err(Errno::NOENT) => Ok(None),
            Err(e) => Err(self.system(name, &e.into())),
        }
    }

    /// Checks that a file in the folder has this type and belongs to the folder's owner.
    fn own(&self, name: &str, stat: &Stat, ty: FileType) -> Result<(), FolderError> {
        let path = || self.path.join(name).into();
        match FileType::from_raw_mode(stat.st_mode) {
            FileType::Symlink => return Err(FolderError::Link { path: path() }),
            found if found == ty => {}
            _ if ty == FileType::Socket => return Err(FolderError::NoSocket { path: path() }),
            _ => {
                let why = "it is not a regular file".into();
                return Err(FolderError::System { path: path(), why });
            }
        }
        if stat.st_uid == self.owner {
            return Ok(());
        }
        Err(FolderError::Owner { path: path(), owner: stat.st_uid, expected: self.owner })
    }

    fn system(&self, name: &str, error: &std::io::Error) -> FolderError {
        FolderError::System { path: self.path.join(name).into(), why: reason(error) }
    }
}

/// Returns whether a folder is a system service's that lets its group in.
const fn is_of_service(stat: &Stat) -> bool {
    let user = stat.st_uid;
    stat.st_mode & OTHERS_USE == SERVICE_GROUP && user != ROOT && user < FIRST_PERSON
}

/// Returns the system's error text without the error number.
fn reason(error: &std::io::Error) -> Box<str> {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).into()
}

#[cfg(test)]
mod tests {
    use super::{Folder, FolderError};
    use crate::Place;
    use std::{
        fs,
        io::Write,
        os::unix::fs::{MetadataExt, chown, symlink},
    };

    #[test]
    fn a_folder_of_sockets_is_closed_to_others() {
        use std::os::unix::fs::PermissionsExt as _;
        let path = std::env::temp_dir().join(format!("hal-closed-{}", std::process::id()));
        let place = Place::at(&path, "default").unwrap();
        for mode in [0o755, 0o711, 0o750, 0o700] {
            fs::create_dir_all(&path).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            drop(Folder::make(&place).unwrap());
            let (now, owner) =
                (fs::metadata(&path).unwrap().mode(), fs::metadata(&path).unwrap().uid());
            let is_service = owner != super::ROOT && owner < super::FIRST_PERSON;
            let wanted = if mode == 0o750 && is_service { 0o750 } else { 0o700 };
            assert_eq!(now & 0o7777, wanted, "{mode:o}");
        }
        fs::remove_dir_all(&path).unwrap();
    }

    #[test]
    fn a_log_is_a_file_of_the_user_and_not_long() {
        let path = std::env::temp_dir().join(format!("hal-log-{}", std::process::id()));
        let place = Place::at(&path, "default").unwrap();
        let folder = Folder::make(&place).unwrap();
        let log = path.join(place.log_name());
        let open = || folder.log(&place);
        open().unwrap().write_all(b"first\n").unwrap();
        open().unwrap().write_all(b"second\n").unwrap();
        assert_eq!(fs::read_to_string(&log).unwrap(), "first\nsecond\n");
        // Only root can give a file to another user.
        let me = fs::metadata(&log).unwrap().uid();
        if me == 0 {
            chown(&log, Some(60_001), None).unwrap();
            let refused = open().unwrap_err();
            assert!(
                matches!(refused, FolderError::Owner { owner: 60_001, expected: 0, .. }),
                "{refused:?}"
            );
            chown(&log, Some(me), None).unwrap();
        }
        fs::write(&log, vec![b'x'; 1 << 20]).unwrap();
        open().unwrap().write_all(b"y").unwrap();
        assert_eq!(fs::metadata(&log).unwrap().len(), (1 << 20) + 1);
        open().unwrap().write_all(b"new").unwrap();
        assert_eq!(fs::read_to_string(&log).unwrap(), "new");
        fs::remove_file(&log).unwrap();
        symlink("elsewhere", &log).unwrap();
        assert!(open().is_err() && !path.join("elsewhere").exists());
        fs::remove_file(&log).unwrap();
        fs::create_dir(&log).unwrap();
        assert!(open().is_err());
        fs::remove_dir_all(&path).unwrap();
    }
}
