//! Files that programs write: `LOGOPEN`, `LOGAPPEND` and `PROBEOPEN`.
//!
//! A program comes from anywhere, so that it writes below the output folder and nowhere else.

use crate::outside::{FileAction, FileKind};
use hal_beneath::{NameError, OpenError, RelativeName, is_below};
use hal_job::places::Output;
use std::{
    collections::BTreeMap,
    fs::File,
    io::{Error, Write},
    path::{Path, PathBuf},
};

/// Largest file in bytes.
const MAX_LEN: u64 = 1 << 30;

/// The open files of a program.
#[derive(Debug, Default)]
pub(super) struct ProgramFiles(BTreeMap<FileKind, OutputFile>);

/// The folder that a program writes to, and files there that it must leave alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds<'a> {
    pub(super) output: Option<&'a Output>,
    pub(super) program: Option<&'a Path>,
    /// Files that the task itself writes, and those that the INI file names.
    pub(super) own: &'a [&'a Path],
}

/// A file that grows, line by line.
#[derive(Debug)]
struct OutputFile {
    path: PathBuf,
    /// `None` after a failure.
    file: Option<File>,
}

impl ProgramFiles {
    /// Opens a file, writes a line to it, or closes it.
    pub(super) fn act(&mut self, action: &FileAction, bounds: Bounds<'_>) -> Result<(), String> {
        match action {
            FileAction::Open { kind, name, append } => {
                self.0.remove(kind);
                let opened = bounds.open(name, *append)?;
                self.0.insert(*kind, opened);
                Ok(())
            }
            FileAction::Line(kind, text) => match self.0.get_mut(kind) {
                Some(file) => {
                    file.append(format!("{text}\n").as_bytes()).map_err(|e| failed(&file.path, &e))
                }
                None => Ok(()),
            },
            FileAction::Close(kind) => match self.0.remove(kind) {
                Some(file) => file.close(),
                None => Ok(()),
            },
        }
    }
}

impl Bounds<'_> {
    /// Opens a file that a program names, to replace it or to write behind its end.
    fn open(self, name: &str, append: bool) -> Result<OutputFile, String> {
        let none = "there is no INI file, beside which the output folder would be";
        let output = self.output.ok_or_else(|| format!("{name}: {none}"))?;
        let file = RelativeName::parse(name.trim()).map_err(|why| refused(name, why, output))?;
        let path = output.path().join(file.path());
        let mut own = self.own.iter().copied().chain(self.program);
        if own.any(|own| is_below(own, &path)) {
            let path = path.display();
            return Err(format!("{path}: a file of the machine, which a program cannot replace"));
        }
        let opened = output.open(true).and_then(|folder| {
            let folder = folder.folder_of(&file, true)?;
            if append {
                return folder.append(&file.file().clone().into());
            }
            // The file appears now, also without a line.
            folder.replace(file.file())?.appear()
        });
        let opened = opened.map_err(|why: OpenError| why.to_string())?;
        Ok(OutputFile { path, file: Some(opened) })
    }
}

/// Returns the refusal of a name, with the place where such a file would go.
fn refused(name: &str, why: NameError, output: &Output) -> String {
    let folder = output.path();
    let last = name.trim().rsplit('/').find_map(|part| RelativeName::parse(part).ok());
    let place = last.map_or_else(|| folder.join("log.txt"), |last| folder.join(last.path()));
    format!(
        "{}: {why}; programs write below {}, where the file would be {}",
        name.escape_debug(),
        folder.display(),
        place.display()
    )
}

impl OutputFile {
    /// Writes a whole line, or nothing.
    fn append(&mut self, line: &[u8]) -> Result<(), Error> {
        let Some(file) = &mut self.file else { return Err(Error::other("writing has ended")) };
        let before = file.metadata()?.len();
        if before.saturating_add(line.len() as u64) > MAX_LEN {
            return Err(Error::other("longer than 1 GiB"));
        }
        let written = file.write_all(line);
        if written.is_err() {
            // A line that was written in part is taken back.
            file.set_len(before).unwrap_or_default();
            self.file = None;
        }
        written
    }

    fn close(self) -> Result<(), String> {
        let closed = match self.file {
            Some(file) => hal_output::close_file(file),
            None => Err(Error::other("writing has ended")),
        };
        closed.map_err(|e| failed(&self.path, &e))
    }
}

fn failed(path: &Path, error: &Error) -> String {
    format!("{}: {}", path.display(), hal_output::reason(error))
}

/// Replaces a file of the machine as a whole, and keeps its earlier state.
pub(super) fn written(path: &Path, text: &str) -> Result<(), String> {
    hal_output::write_kept(path, text.as_bytes()).map_err(|e| failed(path, &e))
}

#[cfg(test)]
mod tests;
