//! Reasons why a device cannot be used.

use crate::{
    bus::{FoundDevices, Identity},
    described::BadLine,
    spec::{BadSpec, MOST_DEVICES},
};
use core::fmt;
use port::Lost;

/// Reason why the component is not loaded.
#[derive(Clone, Debug)]
pub(crate) enum Refused {
    /// No device is asked for.
    Nothing,
    TooMany,
    /// A specification cannot be read.
    Spec {
        word: String,
        why: BadSpec,
    },
    /// No device matches a specification.
    Missing {
        word: String,
        there: FoundDevices,
    },
    /// A device does not answer.
    Broken {
        number: u32,
        name: String,
        lost: Lost,
    },
    /// The file of descriptions cannot be read.
    File {
        path: String,
        lost: Lost,
    },
    /// A line of that file is wrong.
    Line {
        path: String,
        why: BadLine,
    },
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => write!(
                f,
                "no device: expected devices= with a part of its name, such as devices=Gamepad"
            ),
            Self::TooMany => write!(f, "devices= has too many devices: at most {MOST_DEVICES}"),
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
            Self::Broken { number, name, lost } => write!(
                f,
                "/dev/input/event{number} ('{}') cannot be used: {lost}; or run with --simulate",
                name.escape_debug()
            ),
            Self::File { path, lost } => write!(
                f,
                "describe= has '{}', which cannot be read ({}): expected a file with lines of \
                 /proc/bus/input/devices",
                path.escape_debug(),
                std::io::Error::from_raw_os_error(lost.0)
            ),
            Self::Line { path, why } => write!(f, "{}: {why}", path.escape_debug()),
        }
    }
}

/// Longest list of devices in a message.
const MOST_NAMES: usize = 12;

fn missing(f: &mut fmt::Formatter<'_>, word: &str, there: &FoundDevices) -> fmt::Result {
    write!(f, "no input device matches '{}'", word.escape_debug())?;
    for (at, device) in there.all.iter().take(MOST_NAMES).enumerate() {
        let Identity { name, vendor, product, .. } = &device.identity;
        let begin = if at == 0 { "; there are: " } else { ", " };
        let name = name.escape_debug();
        write!(f, "{begin}'{name}' ({vendor:04x}:{product:04x}, event{})", device.number)?;
    }
    if there.all.len() > MOST_NAMES {
        write!(f, ", and {} more", there.all.len() - MOST_NAMES)?;
    }
    match (there.all.is_empty(), there.forbidden) {
        (true, 0) => write!(f, ": /dev/input has no device; is it plugged in?")?,
        (_, 0) => {}
        (_, n) => write!(
            f,
            "; {n} in /dev/input may not be opened: run as a user in group input (usermod -aG input \
             NAME, then log in again)"
        )?,
    }
    write!(f, "; or run with --simulate")
}
