//! Reasons why a file of `mb2hal`, or an argument, is refused.

use crate::line::RATES;
use core::fmt;
use hal_ini::Entry;

/// Reason why a file is refused.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum BadIni {
    /// The file cannot be read.
    Unreadable(hal_ini::Error),
    /// An entry is missing.
    Missing {
        file: String,
        section: String,
        key: &'static str,
        /// Value that belongs there.
        what: &'static str,
        /// Entry that was probably meant.
        near: Option<String>,
    },
    /// An entry is wrong.
    Entry { entry: Box<Entry>, why: BadEntry },
    /// A section is wrong by what it does not state.
    Section { file: String, section: String, value: String, why: BadEntry },
}

impl BadIni {
    pub(crate) fn bad(entry: &Entry, why: BadEntry) -> Self {
        Self::Entry { entry: Box::new(entry.clone()), why }
    }
}

/// Mistake in an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BadEntry {
    Whole { least: i64, most: i64 },
    Number { least: f64, most: f64 },
    OneOf(&'static [&'static str]),
    Rate,
    Function,
    NeedsVersion,
    TooMany(i64),
    PinNames,
    Beyond,
    SameName,
    TwoSettings,
}

impl fmt::Display for BadEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole { least, most } => {
                write!(f, "a whole number from {least} to {most} is needed")
            }
            Self::Number { least, most } => write!(f, "a number from {least} to {most} is needed"),
            Self::OneOf(list) => write!(f, "one of {} is needed", list.join(", ")),
            Self::Rate => {
                let all: Vec<String> = RATES.iter().map(ToString::to_string).collect();
                write!(f, "a serial line has one of {}", all.join(", "))
            }
            Self::Function => {
                let all: Vec<&str> = super::config::KINDS.iter().map(|(name, _)| *name).collect();
                write!(f, "one of {} is needed", all.join(", "))
            }
            Self::NeedsVersion => f.write_str("this function needs VERSION=1.1 in [MB2HAL_INIT]"),
            Self::TooMany(most) => write!(f, "this function takes at most {most} in one request"),
            Self::PinNames => f.write_str(
                "names with commas between them are needed, of letters, digits, '-', '_' and '.'",
            ),
            Self::Beyond => f.write_str("the last element is beyond address 65535"),
            Self::SameName => f.write_str("another transaction has this name"),
            Self::TwoSettings => {
                f.write_str("another transaction states other settings for the same line")
            }
        }
    }
}

impl fmt::Display for BadIni {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(error @ hal_ini::Error::File { .. }) => {
                write!(f, "{error}: ini= must be a file of mb2hal, such as mb2hal.ini")
            }
            Self::Unreadable(error) => error.fmt(f),
            Self::Missing { file, section, key, what, near } => {
                write!(f, "{file}: [{section}]{key} is missing: {what}")?;
                near.as_ref().map_or(Ok(()), |near| write!(f, " (did you mean {near}?)"))
            }
            Self::Entry { entry, why } => write!(
                f,
                "{}:{}: [{}]{}={}: {why}",
                entry.file, entry.line, entry.section, entry.name, entry.value
            ),
            Self::Section { file, section, value, why } => {
                write!(f, "{file}: [{section}] {value}: {why}")
            }
        }
    }
}

impl core::error::Error for BadIni {}

/// Argument that is refused.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum BadArgument {
    /// A file and transactions.
    Both,
    /// A device that is neither a path nor an address.
    Device(String),
    /// A rate that no line has.
    Rate(i64),
    /// There is no such parity.
    Parity(String),
    /// A transaction that is none.
    Transaction(String),
    /// The file.
    Ini(BadIni),
}

impl fmt::Display for BadArgument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Both => f.write_str("ini= and transactions=: only one of them is possible"),
            Self::Device(text) => write!(
                f,
                "device={text}: must be a path such as /dev/ttyUSB0, or HOST:PORT such as 192.168.1.9:502"
            ),
            Self::Rate(rate) => write!(f, "rate={rate}: {}", BadEntry::Rate),
            Self::Parity(text) => write!(f, "parity={text}: must be none, even or odd"),
            Self::Transaction(text) => write!(
                f,
                "transactions={text}: NAME:FUNCTION:FIRST:COUNT is needed, such as inputs:02:0:8, with the functions 01 to 06, 15 and 16, and as many elements as one request holds"
            ),
            Self::Ini(bad) => bad.fmt(f),
        }
    }
}

impl core::error::Error for BadArgument {}
