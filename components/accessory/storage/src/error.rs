//! Every error of the storage.

use crate::{bay::Side, ledger::WrongLedger, name::WrongName};
use core::fmt;

/// Reason why the storage does not do something.
#[derive(Debug)]
pub enum StorageError {
    /// A job's name is wrong: the name as it was given.
    Name(Box<str>, WrongName),
    /// A job is larger than a job may be: its name, its bytes, the most.
    Large(Box<str>, u64, u64),
    /// A job is empty: its name.
    Empty(Box<str>),
    /// Too many jobs wait: the most.
    Waiting(usize),
    /// No job has this name.
    Unknown(Box<str>),
    /// The image has no room: the bytes of all jobs, the bytes that fit.
    Room(u64, u64),
    /// The state file is wrong: its line, and the reason.
    Ledger(usize, WrongLedger),
    /// An image cannot be made, read or written: the image, the job if it is about one, the reason.
    Image(Side, Option<Box<str>>, std::io::Error),
    /// A job reads back otherwise than it was written: the image and the job.
    Different(Side, Box<str>),
    /// The state file or a waiting job cannot be read or written.
    Keeping(Box<str>, std::io::Error),
    /// The USB device does not take an image, or does not give it back: the image and the reason.
    Gadget(Side, std::io::Error),
    /// The host holds the medium: seconds for which it was asked to let go.
    Busy(u32),
}

impl fmt::Display for StorageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = hal_output::reason;
        match self {
            Self::Name(name, why) => write!(f, "job '{name}': {why}"),
            Self::Large(name, bytes, most) => {
                write!(f, "job '{name}' has {bytes} bytes, the most is {most}")
            }
            Self::Empty(name) => write!(f, "job '{name}' is empty"),
            Self::Waiting(most) => write!(f, "{most} jobs wait already"),
            Self::Unknown(name) => write!(f, "no job has the name '{name}'"),
            Self::Room(bytes, most) => write!(
                f,
                "the jobs have {bytes} bytes together, and {most} fit: mark a job as finished, or cancel one that waits"
            ),
            Self::Ledger(line, why) => write!(f, "the state file, line {line}: {why}"),
            Self::Image(side, None, why) => write!(f, "image {side}: {}", reason(why)),
            Self::Image(side, Some(job), why) => {
                write!(f, "image {side}, job '{job}': {}", reason(why))
            }
            Self::Different(side, job) => {
                write!(f, "image {side}, job '{job}' reads back otherwise than it was written")
            }
            Self::Keeping(what, why) => write!(f, "{what}: {}", reason(why)),
            Self::Gadget(side, why) => write!(f, "USB device, image {side}: {}", reason(why)),
            Self::Busy(seconds) => {
                write!(
                    f,
                    "the host has held the medium for {seconds} s: stop its job, or allow a forced eject"
                )
            }
        }
    }
}
