//! INI files: the configuration of a machine, with file and line of every entry.
//!
//! The format is LinuxCNC's: `[SECTION]` headers, `NAME = value` entries, comment lines that begin
//! with `#` or `;`, lines continued with a backslash at their end, and `#INCLUDE FILE`, whose path
//! is relative to the file that contains it. Any other line is ignored with a warning, as is a file to include
//! that is not there; a text without any section is an error. Names may repeat: a look-up returns the first one,
//! [`Ini::all`] returns all of them.
//!
//! ```
//! let ini = hal_ini::Ini::parse("mill.ini", b"[JOINT_0]\nMAX_VELOCITY = 50\n")?;
//! assert_eq!(ini.get("JOINT_0", "MAX_VELOCITY"), Some("50"));
//! # Ok::<(), hal_ini::Error>(())
//! ```
#![forbid(unsafe_code)]

mod error;
pub mod file;
mod machine_files;
mod place;
mod read;
mod syntax;
mod warning;

pub use error::Error;
pub use machine_files::Purpose;
pub use place::beside;
pub use warning::{Doubt, IniWarning};

use std::path::Path;

/// Maximum depth to which files may include each other.
pub const MAX_DEPTH: u32 = 16;
/// Maximum number of files that form one INI file.
pub const MAX_FILES: u32 = 1000;
/// Maximum size of an INI file in bytes, including all included files.
pub const MAX_BYTES: u64 = 64 << 20;

/// Maximum number of warnings about one INI file.
pub const MAX_WARNINGS: usize = 100;

/// A `NAME = value` entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Section, without brackets.
    pub section: String,
    /// Name of the entry.
    pub name: String,
    /// Value with escapes decoded.
    pub value: String,
    /// File that contains the entry.
    pub file: String,
    /// Line number in that file, from 1. For a continued entry, the last line.
    pub line: u32,
}

impl Entry {
    fn is(&self, section: &str, name: &str) -> bool {
        self.name == name && (section.is_empty() || self.section == section)
    }
}

/// An INI file together with all files that it includes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ini {
    entries: Vec<Entry>,
    sections: Vec<String>,
    warnings: Vec<IniWarning>,
    broken: Option<Error>,
}

impl Ini {
    /// Reads a file for a script. If a line is malformed, the result has no entries and
    /// [`Self::broken`] returns the reason, so that a script can run until it needs an entry.
    ///
    /// # Errors
    /// [`Error::File`]: the file cannot be read.
    pub fn open(path: &Path) -> Result<Self, Error> {
        match Self::read(path) {
            Err(error @ Error::Syntax { .. }) => {
                Ok(Self { broken: Some(error), ..Self::default() })
            }
            other => other,
        }
    }

    /// Returns the error of a malformed line, because of which the file has no entries.
    #[must_use]
    pub const fn broken(&self) -> Option<&Error> {
        self.broken.as_ref()
    }

    /// Reads a file and the files that it includes.
    ///
    /// # Errors
    /// [`Error::File`]: the file cannot be read. [`Error::Syntax`]: a line is malformed, or an included file cannot be
    /// read.
    pub fn read(path: &Path) -> Result<Self, Error> {
        read::file(path)
    }

    /// Parses a text. `name` is the path of its file, for messages and for the files that it includes.
    ///
    /// # Errors
    /// [`Error::Syntax`]: a line is malformed, or an included file cannot be read.
    pub fn parse(name: &str, text: &[u8]) -> Result<Self, Error> {
        read::text(Path::new(name), text)
    }

    /// Returns the first value of this name in the section. An empty `section` means any section.
    #[must_use]
    pub fn get(&self, section: &str, name: &str) -> Option<&str> {
        self.entries.iter().find(|e| e.is(section, name)).map(|e| e.value.as_str())
    }

    /// Replaces the value of the first entry with this name in the section. Returns whether there
    /// is one.
    pub fn change(&mut self, section: &str, name: &str, value: &str) -> bool {
        let entry = self.entries.iter_mut().find(|e| e.is(section, name));
        entry.map(|e| value.clone_into(&mut e.value)).is_some()
    }

    /// Returns an iterator over the entries with this name in the section, in order.
    pub fn all<'a>(&'a self, section: &str, name: &str) -> impl Iterator<Item = &'a Entry> {
        self.entries.iter().filter(move |e| e.is(section, name))
    }

    /// Returns an iterator over the entries of a section, in order.
    pub fn section<'a>(&'a self, section: &str) -> impl Iterator<Item = &'a Entry> {
        self.entries.iter().filter(move |e| e.section == section)
    }

    /// Returns an iterator over all entries, in order.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter()
    }

    /// Returns whether there is a section of this name.
    #[must_use]
    pub fn has_section(&self, name: &str) -> bool {
        self.sections.iter().any(|s| s == name)
    }

    /// Returns an iterator over all entries as `[SECTION]NAME`, in order.
    pub fn names(&self) -> impl Iterator<Item = String> {
        self.entries.iter().map(|e| format!("[{}]{}", e.section, e.name))
    }

    /// Returns warnings about legal but doubtful lines.
    #[must_use]
    pub fn warnings(&self) -> &[IniWarning] {
        &self.warnings
    }

    /// Returns whether the machine's unit of length, `[TRAJ]LINEAR_UNITS`, is the inch; else it is the millimetre.
    ///
    /// # Errors
    ///
    /// The entry, if it is neither.
    pub fn is_inch(&self) -> Result<bool, &Entry> {
        let Some(entry) = self.all("TRAJ", "LINEAR_UNITS").next() else { return Ok(false) };
        match entry.value.trim().to_ascii_lowercase().as_str() {
            "inch" | "in" | "imperial" => Ok(true),
            "mm" | "metric" => Ok(false),
            // Older files have the number of units in a millimetre.
            text => match text.parse::<f64>() {
                Ok(1.0) => Ok(false),
                Ok(n) if (n * 25.4 - 1.0).abs() < 1e-3 => Ok(true),
                _ => Err(entry),
            },
        }
    }

    /// Returns the letter of each joint's axis, in the order of the joints: those that `trivkins coordinates=` of
    /// `[KINS]KINEMATICS` states, else those of `[TRAJ]COORDINATES`. Returns `None` if neither is there.
    #[must_use]
    pub fn joint_letters(&self) -> Option<String> {
        let mut words = self.get("KINS", "KINEMATICS").unwrap_or_default().split_whitespace();
        let stated = (words.next() == Some("trivkins"))
            .then(|| words.find_map(|word| word.strip_prefix("coordinates=")))
            .flatten();
        let letters = stated.or_else(|| self.get("TRAJ", "COORDINATES"))?;
        Some(letters.replace(char::is_whitespace, "").to_ascii_uppercase())
    }

    /// Returns whether the file has LinuxCNC's old format, with `[AXIS_0]` and without `[JOINT_0]`.
    /// Pins then have their old names.
    #[must_use]
    pub fn is_old(&self) -> bool {
        let numbered = |prefix: &str| {
            self.sections.iter().any(|s| {
                s.strip_prefix(prefix)
                    .is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
            })
        };
        numbered("AXIS_") && !numbered("JOINT_")
    }

    /// Returns the entry nearest to `[SECTION]NAME`, and whether the user probably meant it. That
    /// is so if it has this name in another section, or a similar name in this section.
    #[must_use]
    pub fn nearest(&self, section: &str, name: &str) -> Option<(String, bool)> {
        let apart =
            |a: &str, b: &str| strsim::damerau_levenshtein(&a.to_lowercase(), &b.to_lowercase());
        let rank = |e: &Entry| {
            let (far, whole) = (apart(name, &e.name), apart(section, &e.section));
            let meant = far == 0 || far + whole <= 2 || (whole == 0 && far <= 1 + name.len() / 3);
            (!meant, far + whole)
        };
        let (best, (far, _)) =
            self.entries.iter().map(|e| (e, rank(e))).min_by_key(|(_, rank)| *rank)?;
        Some((format!("[{}]{}", best.section, best.name), !far))
    }
}

#[cfg(test)]
mod tests;
