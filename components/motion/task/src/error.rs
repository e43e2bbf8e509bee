//! Errors of programs of users, M100 to M199.

use ::core::fmt;
use hal_ini::Entry;
use hal_job::number::wrong;

/// Reason for which a program of a user is not run, or its rights are not known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum UserProgramError {
    /// There is a user's program of this code, and it is not run.
    NotRun {
        /// The code, 100 to 199.
        code: u16,
        /// The fault of the file.
        why: Box<str>,
    },
    /// No folder has a user's program of this code.
    NoProgram(u16),
    /// The system does not start a user's program.
    NotStarted {
        /// The code, 100 to 199.
        code: u16,
        /// The reason of the system.
        why: Box<str>,
    },
    /// An entry of the INI file does not say which rights users' programs have.
    UserCodes(Box<Entry>),
}

impl fmt::Display for UserProgramError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotRun { code, why } => write!(f, "M{code} is not run: {why}"),
            Self::NoProgram(code) => write!(f, "there is no program M{code}"),
            Self::NotStarted { code, why } => write!(f, "M{code}: {why}"),
            Self::UserCodes(entry) => f.write_str(&wrong(entry, "limited or full")),
        }
    }
}

impl ::core::error::Error for UserProgramError {}
