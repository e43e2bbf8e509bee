//! Events that a person has to know.

use core::fmt;

/// Event that a person has to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Note {
    /// The inverter does not take a setting: its number, the value that was sent, and the one that was answered.
    Refused(u8, u16, u16),
    /// The inverter has stopped while it was commanded to run.
    Stopped,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(number, sent, answered) => write!(
                f,
                "the inverter does not take {sent} for PD{number:03}, and answers {answered}: the spindle stands until the component is loaded with another value"
            ),
            Self::Stopped => f.write_str(
                "the inverter has stopped by itself, as after a trip: the spindle stands until a person commands it anew",
            ),
        }
    }
}
