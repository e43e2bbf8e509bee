//! Errors of the files that are read and written, in the user's words.

use crate::Report;
use core::fmt;
use std::{io, path::Path};

/// Error around the files themselves.
#[derive(Debug)]
#[expect(missing_docs, reason = "the sentence of each variant is its documentation")]
pub enum Error {
    Io { path: Box<str>, cause: io::Error },
    Faults(Report),
    UnixEnds { path: Box<str> },
    NoHeaders { folder: Box<str> },
    NoCompiler { compiler: Box<str>, cause: io::Error },
    Compiler { compiler: Box<str>, file: Box<str> },
    Unresolved { file: Box<str> },
    Object { path: Box<str>, cause: Box<str> },
    Ending { path: Box<str> },
    NotFor { path: Box<str>, action: &'static str, kinds: &'static str },
    NoPlace { what: &'static str, variable: &'static str },
    NoLibrary { library: &'static str, folder: Box<str> },
    OutForSeveral,
}

/// Returns a function that adds this path to an I/O error.
pub(crate) fn at(path: &Path) -> impl FnOnce(io::Error) -> Error {
    let path = path.display().to_string().into();
    move |cause| Error::Io { path, cause }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, cause } => write!(f, "{path}: {}", hal_output::reason(cause)),
            Self::Faults(report) => write!(f, "{}", report.to_string().trim_end()),
            Self::UnixEnds { path } => {
                write!(f, "{path}: lines end as DOS writes them (\\r\\n); --unix wants \\n alone")
            }
            Self::NoHeaders { folder } => write!(
                f,
                "{folder}: the headers cannot be laid out there; HAL_INCLUDE_DIR names another folder"
            ),
            Self::NoCompiler { compiler, cause } => write!(
                f,
                "{compiler}: {cause}; a C compiler is needed (apt-get install gcc), and CC names it"
            ),
            Self::Compiler { compiler, file } => {
                write!(f, "{file}: {compiler} refused it; nothing was made")
            }
            Self::Unresolved { file } => write!(
                f,
                "{file}: nothing offers the symbols named above; nothing was made. If another component in C \
                 exports one, RTAPI_IMPORT_SYMBOL(NAME) says so"
            ),
            Self::Object { path, cause } => write!(f, "{path}: {cause}"),
            Self::Ending { path } => write!(f, "{path}: neither .comp, .c nor .py"),
            Self::NotFor { path, action, kinds } => write!(f, "{path}: {action} is for {kinds}"),
            Self::NoPlace { what, variable } => {
                write!(f, "there is no folder for {what}; {variable} names it")
            }
            Self::NoLibrary { library, folder } => write!(
                f,
                "{library} is not in {folder}: programs are linked with it (cargo build makes it)"
            ),
            Self::OutForSeveral => f.write_str("--outfile is for a single file"),
        }
    }
}

impl core::error::Error for Error {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Io { cause, .. } | Self::NoCompiler { cause, .. } => Some(cause),
            Self::Faults(report) => Some(report),
            _ => None,
        }
    }
}

impl From<Report> for Error {
    fn from(report: Report) -> Self {
        Self::Faults(report)
    }
}
