//! Refusals of programs that people elsewhere open.

use core::fmt;
use hal_beneath::{NameError, OpenError};
use std::path::Path;

/// Reason for which a program is not opened for people elsewhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProgramError {
    /// The file is not in the folder of programs.
    Outside {
        /// The file.
        path: Box<Path>,
        /// The folder of programs.
        programs: Box<Path>,
    },
    /// The name is that of no file below a folder.
    Name {
        /// The file.
        path: Box<Path>,
        /// The fault of the name.
        why: NameError,
    },
    /// The file cannot be opened below the folder of programs.
    Open(OpenError),
    /// The system refuses.
    System {
        /// The file.
        path: Box<Path>,
        /// The reason of the system.
        why: Box<str>,
    },
    /// A machine without an INI file does not open it for anybody.
    Own(Box<str>),
}

impl fmt::Display for ProgramError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outside { path, programs } => write!(
                f,
                "{}: programs are opened from afar in {} alone ([DISPLAY]PROGRAM_PREFIX)",
                path.display(),
                programs.display()
            ),
            Self::Name { path, why } => write!(f, "{}: {why}", path.display()),
            Self::Open(why) => write!(f, "{why}"),
            Self::System { path, why } => write!(f, "{}: {why}", path.display()),
            Self::Own(why) => f.write_str(why),
        }
    }
}

impl core::error::Error for ProgramError {}

impl From<ProgramError> for String {
    fn from(why: ProgramError) -> Self {
        why.to_string()
    }
}
