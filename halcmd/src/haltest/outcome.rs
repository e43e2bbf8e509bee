//! What came of a test.

use serde::{Deserialize, Serialize};
use std::{fmt, path::PathBuf};

/// A line of a test's file.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Spot {
    /// The file, as it was named.
    pub file: String,
    /// Its line, from 1.
    pub line: u32,
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// Something that is not as the test wants it, or that is wrong with the test itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Complaint {
    /// Where the test says what it wants.
    pub spot: Spot,
    /// What is wrong, in a sentence.
    pub text: String,
    /// What was expected, what was found, what would be right: a line each.
    pub details: Vec<String>,
}

impl Complaint {
    pub(super) fn new(spot: &Spot, text: impl Into<String>) -> Self {
        Self { spot: spot.clone(), text: text.into(), details: Vec::new() }
    }

    /// With a further line.
    pub(super) fn with(mut self, detail: impl Into<String>) -> Self {
        self.details.push(detail.into());
        self
    }

    /// With what was probably meant, if that is known.
    pub(super) fn near(self, near: Option<impl fmt::Display>) -> Self {
        match near {
            Some(near) => self.with(format!("did you mean '{near}'?")),
            None => self,
        }
    }
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.spot, self.text)?;
        self.details.iter().try_for_each(|line| write!(f, "\n    {line}"))
    }
}

/// A waveform that the test keeps.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Picture {
    /// Where the test asks for it.
    pub spot: Spot,
    /// Its name in the test.
    pub name: String,
    /// The file that it is kept in.
    pub path: PathBuf,
    /// What it looks like now.
    pub drawing: String,
    /// Whether it is what the file has.
    pub same: bool,
}

/// What came of a test.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its file, as it was named.
    pub file: String,
    /// What it shows, in its own words.
    pub about: String,
    /// What is not as it should be; of the waveforms, too.
    pub complaints: Vec<Complaint>,
    /// The waveforms.
    pub pictures: Vec<Picture>,
    /// How long the machine ran, in nanoseconds of its own time.
    pub machine_ns: u64,
    /// What components, the engine and the script said, in order.
    pub said: Vec<String>,
}

impl Outcome {
    /// Whether all was as it should be.
    #[must_use]
    pub const fn passed(&self) -> bool {
        self.complaints.is_empty()
    }

    /// Whether only waveforms are not as they should be: they can be accepted.
    #[must_use]
    pub fn is_acceptable(&self) -> bool {
        let wave = |c: &Complaint| self.pictures.iter().any(|p| p.spot == c.spot && !p.same);
        self.complaints.iter().all(wave)
    }

    /// The waveform of this name, as text.
    #[must_use]
    pub fn drawing(&self, name: &str) -> Option<&str> {
        self.pictures.iter().find(|p| p.name == name).map(|p| p.drawing.as_str())
    }
}

impl fmt::Display for Outcome {
    /// As `haltest` prints it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.passed() { "ok  " } else { "FAIL" };
        let time = crate::units::duration(self.machine_ns);
        write!(f, "{word}  {} ({time})", self.file)?;
        if !self.passed() && !self.about.is_empty() {
            write!(f, "\n  {}", self.about)?;
        }
        for complaint in &self.complaints {
            for line in complaint.to_string().lines() {
                write!(f, "\n  {line}")?;
            }
        }
        Ok(())
    }
}
