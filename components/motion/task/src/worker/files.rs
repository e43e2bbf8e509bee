//! Files that programs write: `LOGOPEN`, `LOGAPPEND` and `PROBEOPEN`.

use crate::outside::{FileAction, FileKind};
use hal_output::Growing;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// The open files of a program.
#[derive(Debug, Default)]
pub(super) struct ProgramFiles(BTreeMap<FileKind, (PathBuf, Growing)>);

impl ProgramFiles {
    /// Opens a file, writes a line to it, or closes it.
    pub(super) fn act(&mut self, action: &FileAction) -> Result<(), String> {
        match action {
            FileAction::Open { kind, name, append } => self.open(*kind, name, *append),
            FileAction::Line(kind, text) => match self.0.get_mut(kind) {
                Some((path, file)) => {
                    file.append(format!("{text}\n").as_bytes()).map_err(|e| failed(path, &e))
                }
                None => Ok(()),
            },
            FileAction::Close(kind) => match self.0.remove(kind) {
                Some((path, file)) => file.finish().map_err(|e| failed(&path, &e)),
                None => Ok(()),
            },
        }
    }

    fn open(&mut self, kind: FileKind, name: &str, append: bool) -> Result<(), String> {
        self.act(&FileAction::Close(kind))?;
        let path = PathBuf::from(name);
        // The open of a pipe that nothing reads never returns.
        let known = std::fs::metadata(&path);
        if known.as_ref().is_ok_and(|known| !known.is_file()) {
            return Err(format!("{name}: not a file"));
        }
        let before = match known.is_ok() && append {
            true => std::fs::read(&path).map_err(|e| failed(&path, &e))?,
            false => Vec::new(),
        };
        let mut file = Growing::create(&path).map_err(|e| failed(&path, &e))?;
        // The file appears now, also without a line.
        file.append(&before).map_err(|e| failed(&path, &e))?;
        self.0.insert(kind, (path, file));
        Ok(())
    }
}

fn failed(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {}", path.display(), hal_output::reason(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_or_continued() {
        let folder = std::env::temp_dir().join(format!("hal-task-files-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("log.txt");
        let name: Box<str> = path.to_string_lossy().into();
        let mut files = ProgramFiles::default();
        let open = |append| FileAction::Open { kind: FileKind::Log, name: name.clone(), append };
        let line = |text: &str| FileAction::Line(FileKind::Log, text.into());
        files.act(&line("nowhere")).unwrap();
        for (append, wanted) in [(false, "a\n"), (true, "a\na\n"), (false, "a\n")] {
            files.act(&open(append)).unwrap();
            files.act(&line("a")).unwrap();
            files.act(&FileAction::Close(FileKind::Log)).unwrap();
            files.act(&line("nowhere")).unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), wanted);
        }
        let none: Box<str> = folder.join("none/log.txt").to_string_lossy().into();
        for (name, why) in [("/dev/full", "not a file"), (&*none, "No such file")] {
            let kind = FileKind::Probe;
            let open = FileAction::Open { kind, name: name.into(), append: false };
            let said = files.act(&open).unwrap_err();
            assert!(said.starts_with(&format!("{name}: {why}")), "{said}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
