//! Names of files below a folder.

use core::fmt;
use std::path::{Path, PathBuf};

/// Longest name of a file in bytes, as file systems have it.
const MAX_BYTES: usize = 255;
/// Largest number of parts of a relative name.
pub const MAX_DEPTH: usize = 8;

/// Characters beyond ASCII that are another form of others, or of which a letter can be composed: two different names
/// would look alike, or become the same where a file system normalises them.
const FORMS: &[(char, char)] = &[
    ('\u{00aa}', '\u{00aa}'),
    ('\u{00b2}', '\u{00b3}'),
    ('\u{00b9}', '\u{00ba}'),
    ('\u{00bc}', '\u{00be}'),
    ('\u{0132}', '\u{0133}'),
    ('\u{013f}', '\u{0140}'),
    ('\u{0149}', '\u{0149}'),
    ('\u{017f}', '\u{017f}'),
    ('\u{01c4}', '\u{01cc}'),
    ('\u{01f1}', '\u{01f3}'),
    ('\u{02b0}', '\u{02e4}'),
    ('\u{0300}', '\u{036f}'),
    ('\u{1100}', '\u{11ff}'),
    ('\u{1d2c}', '\u{1d6a}'),
    ('\u{1d78}', '\u{1dff}'),
    ('\u{2000}', '\u{2bff}'),
    ('\u{2c7c}', '\u{2c7d}'),
    ('\u{3000}', '\u{3004}'),
    ('\u{3008}', '\u{3030}'),
    ('\u{3099}', '\u{309c}'),
    ('\u{3131}', '\u{33ff}'),
    ('\u{a960}', '\u{a97f}'),
    ('\u{d7b0}', '\u{d7ff}'),
    ('\u{f900}', '\u{ffff}'),
    ('\u{1d400}', '\u{1d7ff}'),
    ('\u{1ee00}', '\u{1eeff}'),
    ('\u{1f000}', '\u{1ffff}'),
    ('\u{2f800}', '\u{2fa1f}'),
    ('\u{e0000}', '\u{10ffff}'),
];

/// Reason why a text names no file below a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NameError {
    /// The name has no characters.
    Empty,
    /// The name begins at the root of all files.
    Absolute,
    /// A part of the name leads to the folder above.
    Parent,
    /// A part of the name has no characters, or is `.`.
    EmptyPart,
    /// A file has a name without folders.
    Separator,
    /// The name of a file or folder begins with a dot.
    Hidden,
    /// A part is longer than file systems permit.
    TooLong(usize),
    /// There are too many folders.
    TooDeep,
    /// A part begins or ends with a blank.
    Blank,
    /// A character that names do not have.
    Character(char),
    /// A character that is another form of others.
    Form(char),
}

impl fmt::Display for NameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("the name is empty"),
            Self::Absolute => f.write_str("the name is absolute, must be relative"),
            Self::Parent => f.write_str("the name has '..', which leads to the folder above"),
            Self::EmptyPart => f.write_str("a part of the name is empty or '.'"),
            Self::Separator => f.write_str("the name has a '/', must be that of a file alone"),
            Self::Hidden => {
                f.write_str("hidden: the name of the file or a folder begins with a dot")
            }
            Self::TooLong(bytes) => {
                write!(f, "the name has {bytes} bytes, must be {MAX_BYTES} or fewer")
            }
            Self::TooDeep => write!(f, "the name has more than {MAX_DEPTH} parts"),
            Self::Blank => {
                f.write_str("the name of the file or a folder begins or ends with a blank")
            }
            Self::Character(c) => write!(f, "the name has the character U+{:04X}", u32::from(*c)),
            Self::Form(c) => write!(
                f,
                "the name has U+{:04X}, another form of usual characters or a part of one",
                u32::from(*c)
            ),
        }
    }
}

impl core::error::Error for NameError {}

/// The name of one file or folder: no separator, no dot at its begin, at most 255 bytes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileName(Box<str>);

impl FileName {
    /// Checks a name.
    ///
    /// # Errors
    /// The name leads to another folder, is hidden, too long, or has a character that names do not have.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        if text.is_empty() {
            return Err(NameError::Empty);
        }
        if text == ".." {
            return Err(NameError::Parent);
        }
        if text.contains('/') {
            return Err(NameError::Separator);
        }
        if text.starts_with('.') {
            return Err(NameError::Hidden);
        }
        if text.len() > MAX_BYTES {
            return Err(NameError::TooLong(text.len()));
        }
        text.chars().try_for_each(check)?;
        if text.starts_with(' ') || text.ends_with(' ') {
            return Err(NameError::Blank);
        }
        Ok(Self(text.into()))
    }

    /// Returns the name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

fn check(c: char) -> Result<(), NameError> {
    let is_form = FORMS.iter().any(|(first, last)| (*first..=*last).contains(&c));
    match c {
        '\\' => Err(NameError::Character(c)),
        ' '..='~' => Ok(()),
        _ if is_form => Err(NameError::Form(c)),
        _ if c.is_alphanumeric() => Ok(()),
        _ => Err(NameError::Character(c)),
    }
}

/// The name of a file below a folder, with the folders on the way.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RelativeName {
    folders: Vec<FileName>,
    file: FileName,
}

impl RelativeName {
    /// Checks a name with its folders, between which there is a `/`.
    ///
    /// # Errors
    /// The name is absolute, has `..`, or a part that is the name of no file.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        if text.is_empty() {
            return Err(NameError::Empty);
        }
        if text.starts_with('/') {
            return Err(NameError::Absolute);
        }
        if text.split('/').any(|part| part == "..") {
            return Err(NameError::Parent);
        }
        let mut folders = Vec::new();
        for part in text.split('/') {
            if part.is_empty() || part == "." {
                return Err(NameError::EmptyPart);
            }
            if folders.len() == MAX_DEPTH {
                return Err(NameError::TooDeep);
            }
            folders.push(FileName::parse(part)?);
        }
        let file = folders.pop().ok_or(NameError::Empty)?;
        Ok(Self { folders, file })
    }

    /// Returns the folders on the way.
    #[must_use]
    pub fn folders(&self) -> &[FileName] {
        &self.folders
    }

    /// Returns the name of the file in its folder.
    #[must_use]
    pub const fn file(&self) -> &FileName {
        &self.file
    }

    /// Returns the name as a path.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        let mut path: PathBuf = self.folders.iter().map(FileName::as_str).collect();
        path.push(Path::new(self.file.as_str()));
        path
    }
}

impl From<FileName> for RelativeName {
    fn from(file: FileName) -> Self {
        Self { folders: Vec::new(), file }
    }
}

#[cfg(test)]
mod tests {
    //! Names that lead elsewhere, and those that do not.

    use super::{FileName, MAX_DEPTH, NameError, RelativeName};

    #[test]
    fn a_name_leads_to_no_other_folder() {
        let long = "a".repeat(256);
        for (text, why) in [
            ("", NameError::Empty),
            ("..", NameError::Parent),
            (".", NameError::Hidden),
            (".bashrc", NameError::Hidden),
            ("a/b", NameError::Separator),
            (&*long, NameError::TooLong(256)),
            ("a\0b", NameError::Character('\0')),
            ("a\nb", NameError::Character('\n')),
            ("a\u{7f}", NameError::Character('\u{7f}')),
            ("a\\b", NameError::Character('\\')),
            (" a", NameError::Blank),
            ("a ", NameError::Blank),
            // "é" of two characters, a letter of full width, a leader of two dots, a slash of full width, an override of
            // direction, a joiner without width.
            ("cafe\u{301}", NameError::Form('\u{301}')),
            ("\u{ff2d}101", NameError::Form('\u{ff2d}')),
            ("\u{2025}", NameError::Form('\u{2025}')),
            ("a\u{ff0f}b", NameError::Form('\u{ff0f}')),
            ("cgn.\u{202e}a", NameError::Form('\u{202e}')),
            ("a\u{200d}", NameError::Form('\u{200d}')),
            ("a\u{fffd}", NameError::Form('\u{fffd}')),
        ] {
            assert_eq!(FileName::parse(text), Err(why), "{text:?}");
        }
        for text in ["a", "probe results 1.txt", "café.txt", "деталь.ngc", "部品.ngc", &long[1..]]
        {
            assert_eq!(FileName::parse(text).unwrap().as_str(), text);
        }
    }

    #[test]
    fn a_relative_name_stays_below() {
        let deep = |n: usize| vec!["a"; n].join("/");
        for (text, why) in [
            ("", NameError::Empty),
            ("/a", NameError::Absolute),
            ("//a", NameError::Absolute),
            ("../a", NameError::Parent),
            ("a/../../b", NameError::Parent),
            ("a/..", NameError::Parent),
            ("a//b", NameError::EmptyPart),
            ("a/", NameError::EmptyPart),
            ("./a", NameError::EmptyPart),
            ("a/.ssh/b", NameError::Hidden),
            (&*deep(MAX_DEPTH + 1), NameError::TooDeep),
        ] {
            assert_eq!(RelativeName::parse(text), Err(why), "{text:?}");
        }
        let good = RelativeName::parse("probes/part 1/a.txt").unwrap();
        assert_eq!(good.path().to_str(), Some("probes/part 1/a.txt"));
        assert_eq!((good.folders().len(), good.file().as_str()), (2, "a.txt"));
        RelativeName::parse(&deep(MAX_DEPTH)).unwrap();
    }
}
