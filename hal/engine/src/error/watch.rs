//! Errors of samples, recordings and the flight recorder.

use hal_protocol::MAX_CHANNELS;

/// The reason why something cannot be sampled or recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the sentence of each variant is its documentation")]
pub enum WatchError {
    NoThread,
    NoNames,
    NoMatch { pattern: Box<str> },
    Port { name: Box<str> },
    TooMany { channels: usize },
    TooDeep { depth: u32, most: u32 },
    NoSample { id: u64 },
    Here,
    NotRecording,
    FlightOff,
    FlightSize { bytes: u64 },
    NoEvent,
    Condition(hal_trace::trigger::ConditionError),
    Ending { said: Box<str> },
    Recording { path: Box<str> },
}

impl core::fmt::Display for WatchError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoThread => f.write_str("there is no thread to sample in"),
            Self::NoNames => f.write_str("no pin to sample is named"),
            Self::NoMatch { pattern } => write!(f, "nothing matches '{pattern}'"),
            Self::Port { name } => write!(f, "'{name}' is a port and has no value to sample"),
            Self::TooMany { channels } => {
                write!(f, "{channels} channels at once; at most {MAX_CHANNELS} are possible")
            }
            Self::TooDeep { depth, most } => {
                write!(f, "not enough memory for {depth} samples of this kind: at most {most} fit")
            }
            Self::NoSample { id } => write!(f, "this client has no sample {id}"),
            Self::Here => f.write_str("samples go to programs: ask for them on the socket"),
            Self::FlightOff => f.write_str("the flight recorder is off"),
            Self::FlightSize { bytes } => {
                write!(f, "a flight recorder of {bytes} bytes is not possible: 4 KiB to 4 GiB")
            }
            Self::NoEvent => f.write_str("the flight recorder has seen no event"),
            Self::Condition(e) => e.fmt(f),
            Self::Ending { said } => f.write_str(said),
            Self::NotRecording => f.write_str("nothing is being recorded"),
            Self::Recording { path } => write!(f, "already recording to {path}"),
        }
    }
}

impl WatchError {
    /// Returns the errno of the error.
    pub(crate) const fn errno(&self) -> i32 {
        match self {
            Self::NoMatch { .. } | Self::NoSample { .. } | Self::NoEvent => -2,
            Self::TooDeep { .. } => -12,
            Self::Recording { .. } => -16,
            _ => -22,
        }
    }

    /// Returns the word of the request that is wrong, if it is one word.
    pub(crate) const fn word(&self) -> Option<&str> {
        match self {
            Self::NoMatch { pattern: word } | Self::Port { name: word } => Some(word),
            _ => None,
        }
    }
}

impl From<WatchError> for crate::Error {
    fn from(e: WatchError) -> Self {
        Self::Watch(e)
    }
}

impl From<hal_trace::trigger::ConditionError> for crate::Error {
    fn from(e: hal_trace::trigger::ConditionError) -> Self {
        WatchError::Condition(e).into()
    }
}
