//! A folder of programs, such as that of `halpanel`: files that appear in it or change are jobs.

use std::{
    collections::BTreeMap,
    fs::{self, Metadata},
    path::{Path, PathBuf},
    time::SystemTime,
};

/// Time between two looks, in seconds.
const LOOK: f64 = 1.0;
/// Largest number of files that are looked at.
const FILES: usize = 1024;

/// Length and time of change of a file.
type Mark = (u64, Option<SystemTime>);

/// Folder that is looked at once a second.
pub(crate) struct ProgramsFolder {
    path: PathBuf,
    seen: BTreeMap<String, Mark>,
    next: f64,
    is_lost: bool,
}

/// Result of a look.
#[derive(Default)]
pub(crate) struct Look {
    /// Names of the files that are new or have changed, sorted.
    pub(crate) changed: Vec<String>,
    /// Reason why the folder cannot be read, the first time.
    pub(crate) failed: Option<std::io::Error>,
}

impl ProgramsFolder {
    pub(crate) fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), seen: BTreeMap::new(), next: 0.0, is_lost: false }
    }

    /// Returns the path of a file in the folder.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Looks at the folder, if it is time. `is_known` says which of the files that are there at the first look are jobs already.
    pub(crate) fn look(&mut self, now: f64, is_known: impl Fn(&str) -> bool) -> Look {
        let mut look = Look::default();
        if now < self.next {
            return look;
        }
        let is_first = self.next == 0.0;
        self.next = now + LOOK;
        let files = match self.list() {
            Ok(files) => files,
            Err(e) => {
                look.failed = (!self.is_lost).then_some(e);
                self.is_lost = true;
                return look;
            }
        };
        self.is_lost = false;
        let is_new = |(name, mark): &(&String, &Mark)| {
            self.seen.get(*name) != Some(*mark) && !(is_first && is_known(name))
        };
        look.changed = files.iter().filter(is_new).map(|(name, _)| name.clone()).collect();
        self.seen = files;
        look
    }

    fn list(&self) -> std::io::Result<BTreeMap<String, Mark>> {
        let mut files = BTreeMap::new();
        for entry in fs::read_dir(&self.path)?.take(FILES) {
            let entry = entry?;
            // A file that is being written has a name that begins with a dot until it is whole.
            let name = entry.file_name().to_str().map(str::to_owned);
            let name = name.filter(|name| !name.starts_with('.'));
            let data = entry.metadata().ok().filter(Metadata::is_file);
            if let (Some(name), Some(data)) = (name, data) {
                files.insert(name, (data.len(), data.modified().ok()));
            }
        }
        Ok(files)
    }
}
