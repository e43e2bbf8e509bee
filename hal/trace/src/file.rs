//! Trace files, selected by their extension.

use crate::{Flaw, Position, Reading, Trace, csv, fst, json, vcd};
use hal_output::{Whole, reason};
use std::{
    io::{ErrorKind, Write},
    path::{Path, PathBuf},
};

/// Format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.vcd`
    Vcd,
    /// `.fst`
    Fst,
    /// `.csv`
    Csv,
    /// `.json`
    Json,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Vcd, Self::Fst, Self::Csv, Self::Json];

    /// Returns the file name extension.
    #[must_use]
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Vcd => "vcd",
            Self::Fst => "fst",
            Self::Csv => "csv",
            Self::Json => "json",
        }
    }

    /// Returns the format that the extension of a path selects.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?;
        Self::ALL.into_iter().find(|f| f.ending().eq_ignore_ascii_case(ending))
    }

    /// Parses the bytes of a file.
    #[must_use]
    pub fn read(self, bytes: &[u8]) -> Reading {
        match self {
            Self::Vcd => vcd::read(bytes),
            Self::Fst => fst::read(bytes),
            Self::Csv => csv::read(bytes),
            Self::Json => json::read(bytes),
        }
    }

    /// Writes a trace in this format.
    ///
    /// # Errors
    /// An error of the output, or the format cannot hold the trace.
    pub fn write<W: Write>(self, out: W, trace: &Trace) -> std::io::Result<()> {
        match self {
            Self::Vcd => vcd::write(out, trace).map(drop),
            Self::Fst => fst::write(out, trace),
            Self::Csv => csv::write(out, trace),
            Self::Json => json::write(out, trace).map(drop),
        }
    }
}

/// Error of reading or writing a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileError {
    /// The extension is unknown.
    Ending(PathBuf),
    /// The system returned an error.
    System(PathBuf, Box<str>),
    /// The reader of a pipe has closed its end.
    ReaderGone(PathBuf),
    /// The file has a flaw at this place.
    Flaw(PathBuf, Position, Flaw),
}

impl core::fmt::Display for FileError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Ending(path) => {
                write!(f, "{}: a file ends in .vcd, .fst, .csv or .json", path.display())
            }
            Self::System(path, why) => write!(f, "{}: {why}", path.display()),
            Self::ReaderGone(path) => write!(f, "{}: its reader has closed it", path.display()),
            Self::Flaw(path, place, flaw) => {
                write!(f, "{}:", path.display())?;
                match place {
                    Position::File => {}
                    Position::Line(n) => write!(f, "{n}:")?,
                    Position::Byte(n) => write!(f, " byte {n}:")?,
                }
                write!(f, " {flaw}")
            }
        }
    }
}

impl core::error::Error for FileError {}

impl FileError {
    /// Returns the error for an I/O error on a file.
    #[must_use]
    pub fn of(path: &Path, error: &std::io::Error) -> Self {
        match error.kind() {
            ErrorKind::BrokenPipe => Self::ReaderGone(path.to_owned()),
            _ => Self::System(path.to_owned(), reason(error).into()),
        }
    }
}

/// Reads a file as far as possible. The second value is the error that stopped the reading, if any.
///
/// # Errors
/// The file cannot be read, or its extension is unknown.
pub fn load(path: &Path) -> Result<(Reading, Option<FileError>), FileError> {
    let format = Format::of(path).ok_or_else(|| FileError::Ending(path.to_owned()))?;
    let bytes = std::fs::read(path).map_err(|e| FileError::of(path, &e))?;
    let reading = format.read(&bytes);
    let flaw = reading.flaw.clone().map(|(at, flaw)| FileError::Flaw(path.to_owned(), at, flaw));
    Ok((reading, flaw))
}

/// Writes a file as a whole. A file of the same name stays unchanged until everything is written. A
/// device file without an extension receives CSV.
///
/// # Errors
/// The extension is unknown, the system returned an error, or the format cannot hold the trace.
pub fn save(path: &Path, trace: &Trace) -> Result<(), FileError> {
    let device = path.starts_with("/dev").then_some(Format::Csv);
    let format = Format::of(path).or(device);
    let format = format.ok_or_else(|| FileError::Ending(path.to_owned()))?;
    let mut file = Whole::create(path).map_err(|e| FileError::of(path, &e))?;
    format.write(&mut file, trace).and_then(|()| file.finish()).map_err(|e| FileError::of(path, &e))
}
