//! The result of a test.

use serde::{Deserialize, Serialize};
use std::{fmt, path::PathBuf};

/// A line of a test's file.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Spot {
    /// The file, as it was named on the command line or in another test.
    pub file: String,
    /// Line number, from 1.
    pub line: u32,
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// An expectation that failed, or an error in the test itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Complaint {
    /// Line of the test that states the expectation.
    pub spot: Spot,
    /// The problem, in a sentence.
    pub text: String,
    /// Expected value, found value and remedy: one line each.
    pub details: Vec<String>,
}

impl Complaint {
    pub(super) fn new(spot: &Spot, text: impl Into<String>) -> Self {
        Self { spot: spot.clone(), text: text.into(), details: Vec::new() }
    }

    /// Adds a line.
    pub(super) fn with(mut self, detail: impl Into<String>) -> Self {
        self.details.push(detail.into());
        self
    }

    /// Adds the probably intended name, if there is one.
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

/// A waveform that the test keeps in a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Picture {
    /// Line of the test that declares it.
    pub spot: Spot,
    /// Name of the waveform in the test.
    pub name: String,
    /// File that keeps the waveform.
    pub path: PathBuf,
    /// The waveform of this run, as text.
    pub drawing: String,
    /// True if the file has the same waveform.
    pub same: bool,
}

/// Result of a test.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    /// The test's file, as it was named.
    pub file: String,
    /// The test's own description.
    pub about: String,
    /// Failed expectations and errors, including those of waveforms.
    pub complaints: Vec<Complaint>,
    /// Waveforms of this run.
    pub pictures: Vec<Picture>,
    /// Machine time of the run in nanoseconds.
    pub machine_ns: u64,
    /// Messages of components, the engine and the script, in order.
    pub said: Vec<String>,
}

impl Outcome {
    /// Returns whether the test passed.
    #[must_use]
    pub const fn passed(&self) -> bool {
        self.complaints.is_empty()
    }

    /// Returns whether all complaints are about waveforms, so that they can be accepted.
    #[must_use]
    pub fn is_acceptable(&self) -> bool {
        let wave = |c: &Complaint| self.pictures.iter().any(|p| p.spot == c.spot && !p.same);
        self.complaints.iter().all(wave)
    }

    /// Returns the waveform with this name, as text.
    #[must_use]
    pub fn drawing(&self, name: &str) -> Option<&str> {
        self.pictures.iter().find(|p| p.name == name).map(|p| p.drawing.as_str())
    }
}

impl fmt::Display for Outcome {
    /// Writes the outcome as `haltest` prints it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.passed() { "ok  " } else { "FAIL" };
        let time = crate::language::units::duration(self.machine_ns);
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
