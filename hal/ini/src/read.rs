//! Reading of files and of the files that they include.

use crate::{
    Doubt, Entry, Error, Ini, IniWarning, MAX_BYTES, MAX_DEPTH, MAX_FILES, MAX_WARNINGS, syntax,
};
use std::{
    collections::BTreeSet,
    io,
    path::{Path, PathBuf},
};

/// Reads a file and the files that it includes.
pub(crate) fn file(path: &Path) -> Result<Ini, Error> {
    let mut reader = Reader::default();
    reader.add_file(path, 0)?;
    reader.end()
}

/// Reads a text as if it were the file `path`.
pub(crate) fn text(path: &Path, text: &[u8]) -> Result<Ini, Error> {
    let mut reader = Reader::default();
    reader.add(path, text, 0)?;
    reader.end()
}

#[derive(Default)]
struct Reader {
    ini: Ini,
    /// Section names already seen in each file, to detect repeated sections.
    begun: BTreeSet<(String, String)>,
    /// Section of the next entry. An included file continues the section of the line that includes it.
    section: Option<String>,
    /// First line before any section, which is an error if no section follows.
    early: Option<Error>,
    /// Number of warnings beyond the limit.
    unsaid: u32,
    files: u32,
    bytes: u64,
}

impl Reader {
    /// Returns the result, if the text is an INI file at all.
    fn end(mut self) -> Result<Ini, Error> {
        if let (Some(early), true) = (self.early, self.ini.sections.is_empty()) {
            return Err(early);
        }
        if let (Some(last), 1..) = (self.ini.warnings.last_mut(), self.unsaid) {
            last.text.push_str(&format!("; {} more warnings are not shown", self.unsaid));
        }
        Ok(self.ini)
    }

    fn warn(&mut self, file: &str, line: u32, doubt: Doubt, text: String) {
        if self.ini.warnings.len() < MAX_WARNINGS {
            self.ini.warnings.push(IniWarning { file: file.to_owned(), line, doubt, text });
        } else {
            self.unsaid = self.unsaid.saturating_add(1);
        }
    }

    fn ignore(&mut self, file: &str, line: u32, why: &str) {
        self.warn(file, line, Doubt::Ignored, format!("this line is ignored: {why}"));
    }

    fn add_file(&mut self, path: &Path, depth: u32) -> Result<(), Error> {
        let refused =
            |why: &str| Error::File { path: path.display().to_string().into(), why: why.into() };
        self.files += 1;
        if self.files > MAX_FILES {
            return Err(refused("it consists of more than 1000 files"));
        }
        let text = self.bytes_of(path).map_err(|e| refused(&plain(&e)))?;
        let text = text.ok_or_else(|| refused("it is larger than 64 MiB"))?;
        self.add(path, &text, depth)
    }

    /// Reads a file if it fits in the remaining byte limit. Returns `None` if it is larger.
    fn bytes_of(&mut self, path: &Path) -> io::Result<Option<Vec<u8>>> {
        let left = MAX_BYTES.saturating_sub(self.bytes);
        let text = crate::file::contents(path, left)?;
        self.bytes += text.as_ref().map_or(left, |t| u64::try_from(t.len()).unwrap_or(u64::MAX));
        Ok(text)
    }

    fn add(&mut self, path: &Path, text: &[u8], depth: u32) -> Result<(), Error> {
        let file = path.display().to_string();
        let wrong = |line: u32, why: &str| {
            let path = file.as_str().into();
            Error::Syntax { path, line, why: why.into() }
        };
        // Some editors begin a file with a mark, which means nothing.
        let text = text.strip_prefix("\u{feff}".as_bytes()).unwrap_or(text);
        for (line, text) in syntax::joined(text) {
            let text = text.ok_or_else(|| wrong(line, "this is not UTF-8"))?;
            let text = text.trim_matches(|c: char| c.is_ascii_whitespace());
            if let Some(name) = text.strip_prefix("#INCLUDE") {
                if depth >= MAX_DEPTH {
                    return Err(wrong(line, "files include each other too deeply (16 at most)"));
                }
                self.include(path, line, name.trim(), depth)?;
            } else if text.is_empty() || text.starts_with(['#', ';']) {
                // A comment.
            } else if text.starts_with('[') {
                let (rest, name) = syntax::header(text)
                    .map_err(|_| wrong(line, "a section is [NAME]: letters, digits and _"))?;
                if !rest.is_empty() && !rest.starts_with(['#', ';']) {
                    let text = format!("the text after [{name}] is ignored");
                    self.warn(&file, line, Doubt::Ignored, text);
                }
                self.begin(&file, line, name);
                self.section = Some(name.to_owned());
            } else if let Some(section) = self.section.clone() {
                let Ok((_, (name, value))) = syntax::entry(text) else {
                    let why = "expected NAME = value, with letters, digits and _ in the name";
                    self.ignore(&file, line, why);
                    continue;
                };
                let value =
                    syntax::decoded(value).ok_or_else(|| wrong(line, "no such character"))?;
                let name = name.to_owned();
                self.ini.entries.push(Entry { section, name, value, file: file.clone(), line });
            } else {
                let early = wrong(line, "this entry is before the first [SECTION]");
                self.early.get_or_insert(early);
                self.ignore(&file, line, "it is before the first [SECTION]");
            }
        }
        Ok(())
    }

    /// Reads the file that the line of another file includes. A file that is not there is ignored, as in LinuxCNC.
    fn include(&mut self, path: &Path, line: u32, name: &str, depth: u32) -> Result<(), Error> {
        let file = path.display().to_string();
        if name.is_empty() {
            self.ignore(&file, line, "#INCLUDE needs the name of a file");
            return Ok(());
        }
        let included = beside(path, name);
        if let Err(error) = std::fs::symlink_metadata(&included)
            && error.kind() == io::ErrorKind::NotFound
        {
            let (name, why) = (included.display(), plain(&error));
            self.ignore(&file, line, &format!("could not open INI file '{name}': {why}"));
            return Ok(());
        }
        self.add_file(&included, depth + 1).map_err(|error| match error {
            Error::File { path, why } => Error::Syntax {
                path: file.into(),
                line,
                why: format!("#INCLUDE: could not open INI file '{path}': {why}").into(),
            },
            other @ Error::Syntax { .. } => other,
        })
    }

    fn begin(&mut self, file: &str, line: u32, name: &str) {
        if !self.begun.insert((name.to_owned(), file.to_owned())) {
            let text = format!("section [{name}] is repeated; its entries are added to the first");
            self.warn(file, line, Doubt::Repeated, text);
            return;
        }
        self.ini.sections.push(name.to_owned());
    }
}

fn beside(path: &Path, name: &str) -> PathBuf {
    path.parent().map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
}

/// Returns the system's error text without the error number.
fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}
