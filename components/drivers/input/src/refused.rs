//! Reasons why a device cannot be used.

use crate::{
    bus::{FoundDevice, Identity},
    described::BadLine,
    spec::BadSpec,
};
use core::fmt;
use port::Lost;
use rustix::io::Errno;
use std::io;

/// Reason why the component is not loaded.
#[derive(Debug)]
pub(crate) enum Refused {
    /// No device is asked for.
    Nothing,
    /// A specification cannot be read.
    Spec { word: String, why: BadSpec },
    /// No device matches a specification.
    Missing { word: String, there: Vec<FoundDevice> },
    /// A device cannot be used.
    Device { number: u32, name: String, why: Unusable },
    /// The file of descriptions cannot be read.
    File { path: String, why: io::Error },
    /// A line of that file is wrong.
    Line { path: String, why: BadLine },
}

/// Reason why a device that is there cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unusable {
    /// The user may not open its node.
    Forbidden,
    /// Another program, or another open node, has grabbed its events.
    Kept,
    /// A button or an axis that has a pin is missing.
    Lacking,
    /// The node cannot be read.
    Unread(Lost),
}

impl Unusable {
    /// Returns the reason why a device was not opened.
    pub(crate) fn new(lost: Lost, is_exclusive: bool) -> Self {
        match Errno::from_raw_os_error(lost.0) {
            Errno::ACCESS | Errno::PERM => Self::Forbidden,
            Errno::BUSY if is_exclusive => Self::Kept,
            _ => Self::Unread(lost),
        }
    }
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Forbidden => write!(
                f,
                "the user may not open its node: run as a user in group input (usermod -aG input NAME, then \
                 log in again)"
            ),
            Self::Kept => write!(
                f,
                "another program, or another word of devices=, keeps its events for itself: end that program, \
                 or leave out the +"
            ),
            Self::Lacking => write!(f, "it lacks a button or an axis that has a pin"),
            Self::Unread(lost) => {
                write!(f, "its node cannot be read ({})", io::Error::from_raw_os_error(lost.0))
            }
        }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => write!(
                f,
                "no device: expected devices= with a part of its name, such as devices=Gamepad"
            ),
            Self::Spec { word, why: BadSpec::NoDevice } => write!(
                f,
                "devices= has '{}' without a device: expected a part of its name, such as -KRAL Gamepad",
                word.escape_debug()
            ),
            Self::Spec { word, why: BadSpec::Letters } => write!(
                f,
                "devices= has '{}': expected letters of K for keys and buttons, R and A for relative and \
                 absolute axes, and L for lights, such as -KRAL Gamepad",
                word.escape_debug()
            ),
            Self::Missing { word, there } => missing(f, word, there),
            Self::Device { number, name, why } => write!(
                f,
                "/dev/input/event{number} ('{}') cannot be used: {why}; or run with --simulate",
                name.escape_debug()
            ),
            Self::File { path, why } => write!(
                f,
                "describe= has '{}', which cannot be read ({why}): expected a file with lines of \
                 /proc/bus/input/devices",
                path.escape_debug()
            ),
            Self::Line { path, why } => write!(f, "{}: {why}", path.escape_debug()),
        }
    }
}

/// Longest list of devices in a message.
const MOST_NAMES: usize = 12;

fn missing(f: &mut fmt::Formatter<'_>, word: &str, there: &[FoundDevice]) -> fmt::Result {
    write!(f, "no input device matches '{}'", word.escape_debug())?;
    for (at, device) in there.iter().take(MOST_NAMES).enumerate() {
        let Identity { name, vendor, product, .. } = &device.identity;
        let begin = if at == 0 { "; there are: " } else { ", " };
        let name = name.escape_debug();
        write!(f, "{begin}'{name}' ({vendor:04x}:{product:04x}, event{})", device.number)?;
    }
    if there.len() > MOST_NAMES {
        write!(f, ", and {} more", there.len() - MOST_NAMES)?;
    }
    if there.is_empty() {
        write!(f, ": /dev/input has no device; is it plugged in?")?;
    }
    write!(f, "; or run with --simulate")
}
