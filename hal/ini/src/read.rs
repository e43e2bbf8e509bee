//! Reading of files and of the files that they include.

use crate::{Entry, Error, Ini, MAX_BYTES, MAX_DEPTH, MAX_FILES, syntax};
use std::{
    collections::BTreeSet,
    io,
    path::{Path, PathBuf},
};

/// Reads a file and the files that it includes.
pub(crate) fn file(path: &Path) -> Result<Ini, Error> {
    let mut reader = Reader::default();
    reader.add_file(path, 0)?;
    Ok(reader.ini)
}

/// Reads a text as if it were the file `path`.
pub(crate) fn text(path: &Path, text: &[u8]) -> Result<Ini, Error> {
    let mut reader = Reader::default();
    reader.add(path, text, 0)?;
    Ok(reader.ini)
}

#[derive(Default)]
struct Reader {
    ini: Ini,
    /// Section names already seen in each file, to detect repeated sections.
    begun: BTreeSet<(String, String)>,
    files: u32,
    bytes: u64,
}

impl Reader {
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
        let mut section: Option<String> = None;
        for (line, text) in syntax::joined(text) {
            let text = text.ok_or_else(|| wrong(line, "this is not UTF-8"))?;
            let text = text.trim_matches(|c: char| c.is_ascii_whitespace());
            if let Some(name) = text.strip_prefix("#INCLUDE") {
                if depth >= MAX_DEPTH {
                    return Err(wrong(line, "files include each other too deeply (16 at most)"));
                }
                let name = name.trim();
                if name.is_empty() {
                    return Err(wrong(line, "#INCLUDE needs the name of a file"));
                }
                self.add_file(&beside(path, name), depth + 1).map_err(|error| match error {
                    Error::File { path, why } => {
                        wrong(line, &format!("#INCLUDE: could not open INI file '{path}': {why}"))
                    }
                    other @ Error::Syntax { .. } => other,
                })?;
            } else if text.is_empty() || text.starts_with(['#', ';']) {
                // A comment.
            } else if text.starts_with('[') {
                let (_, name) = syntax::header(text)
                    .map_err(|_| wrong(line, "a section is [NAME]: letters, digits and _"))?;
                self.begin(&file, line, name);
                section = Some(name.to_owned());
            } else {
                let (_, (name, value)) = syntax::entry(text).map_err(|_| {
                    wrong(line, "expected NAME = value, with letters, digits and _ in the name")
                })?;
                let section = section
                    .clone()
                    .ok_or_else(|| wrong(line, "this entry is before the first [SECTION]"))?;
                let value =
                    syntax::decoded(value).ok_or_else(|| wrong(line, "no such character"))?;
                let name = name.to_owned();
                self.ini.entries.push(Entry { section, name, value, file: file.clone(), line });
            }
        }
        Ok(())
    }

    fn begin(&mut self, file: &str, line: u32, name: &str) {
        if !self.begun.insert((name.to_owned(), file.to_owned())) {
            self.ini.warnings.push(format!(
                "{file}:{line}: Warning: section [{name}] is repeated; its entries are added to \
                 the first"
            ));
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
