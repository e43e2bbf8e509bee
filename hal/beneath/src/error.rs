//! Errors: why a file is not opened, replaced or run.

use crate::name::NameError;
use core::fmt;
use rustix::io::Errno;
use std::{
    io::{self, ErrorKind},
    path::Path,
};

/// Reason why a file below a folder is not used.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the sentence of each variant is its documentation")]
pub enum OpenError {
    Name { name: Box<str>, why: NameError },
    Missing { path: Box<Path> },
    Link { path: Box<Path> },
    HardLink { path: Box<Path> },
    NoFile { path: Box<Path> },
    NoFolder { path: Box<Path> },
    Program { path: Box<Path> },
    Owner { path: Box<Path>, owner: u32, expected: u32 },
    Writable { path: Box<Path>, mode: u32 },
    System { path: Box<Path>, kind: ErrorKind, why: Box<str> },
}

impl OpenError {
    pub(crate) fn system(path: &Path, error: Errno) -> Self {
        match error {
            Errno::NOENT => Self::Missing { path: path.into() },
            // Of RESOLVE_NO_SYMLINKS and O_NOFOLLOW; XDEV is that of RESOLVE_BENEATH.
            Errno::LOOP | Errno::XDEV => Self::Link { path: path.into() },
            _ => {
                let error = io::Error::from(error);
                let text = error.to_string();
                let why = text.split(" (os error").next().unwrap_or(&text).into();
                Self::System { path: path.into(), kind: error.kind(), why }
            }
        }
    }

    /// Returns whether the file, or its folder, is not there.
    #[must_use]
    pub const fn is_missing(&self) -> bool {
        matches!(self, Self::Missing { .. })
    }

    /// Returns whether the name itself is at fault, or what is there under it, and not the system.
    #[must_use]
    pub const fn is_refusal(&self) -> bool {
        !matches!(self, Self::Missing { .. } | Self::System { .. })
    }
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // Text of strangers: without characters that a terminal obeys.
            Self::Name { name, why } => write!(f, "'{}': {why}", name.escape_debug()),
            Self::Missing { path } => write!(f, "{}: No such file or directory", path.display()),
            Self::Link { path } => write!(
                f,
                "{}: a symbolic link is here or on the way, must be the file itself",
                path.display()
            ),
            Self::HardLink { path } => write!(
                f,
                "{}: the file has other names (hard links), must have this one alone",
                path.display()
            ),
            Self::NoFile { path } => write!(f, "{}: not a file", path.display()),
            Self::NoFolder { path } => write!(f, "{}: not a folder", path.display()),
            Self::Program { path } => write!(
                f,
                "{}: an executable file, which only the machine's owner replaces",
                path.display()
            ),
            Self::Owner { path, owner, expected } => write!(
                f,
                "{}: belongs to user {owner}, must belong to user {expected}",
                path.display()
            ),
            Self::Writable { path, mode } => write!(
                f,
                "{}: other users may write it (mode {mode:04o}), only its owner may: chmod go-w",
                path.display()
            ),
            Self::System { path, why, .. } => write!(f, "{}: {why}", path.display()),
        }
    }
}

impl core::error::Error for OpenError {}

impl From<OpenError> for io::Error {
    fn from(error: OpenError) -> Self {
        let kind = match &error {
            OpenError::Missing { .. } => ErrorKind::NotFound,
            OpenError::System { kind, .. } => *kind,
            OpenError::Name { .. } => ErrorKind::InvalidInput,
            _ => ErrorKind::PermissionDenied,
        };
        Self::new(kind, error.to_string())
    }
}
