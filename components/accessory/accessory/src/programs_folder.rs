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
pub(crate) const MAX_FILES: usize = 1024;

/// Length and time of change of a file.
type Mark = (u64, Option<SystemTime>);

/// Folder that is looked at once a second.
pub(crate) struct ProgramsFolder {
    path: PathBuf,
    /// Files at the last look.
    there: BTreeMap<String, Mark>,
    /// Files as they were sent, or were found as jobs.
    sent: BTreeMap<String, Mark>,
    /// Files whose failure was reported, as they were.
    failed: BTreeMap<String, Mark>,
    /// No look was made yet.
    is_first: bool,
    next: f64,
    is_lost: bool,
    is_crowded: bool,
}

/// Result of a look.
#[derive(Default)]
pub(crate) struct Look {
    /// Names of the files that are new or have changed, and have not changed since the look before, sorted.
    pub(crate) changed: Vec<String>,
    /// True if the folder has more files than are looked at, the first time.
    pub(crate) is_crowded: bool,
    /// Reason why the folder cannot be read, the first time.
    pub(crate) failed: Option<std::io::Error>,
}

impl ProgramsFolder {
    pub(crate) fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            there: BTreeMap::new(),
            sent: BTreeMap::new(),
            failed: BTreeMap::new(),
            is_first: true,
            next: 0.0,
            is_lost: false,
            is_crowded: false,
        }
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
        self.next = now + LOOK;
        let (files, is_crowded) = match self.list() {
            Ok(listed) => listed,
            Err(e) => {
                look.failed = (!self.is_lost).then_some(e);
                self.is_lost = true;
                return look;
            }
        };
        self.is_lost = false;
        look.is_crowded = is_crowded && !self.is_crowded;
        self.is_crowded = is_crowded;
        if core::mem::take(&mut self.is_first) {
            let known = files.iter().filter(|(name, _)| is_known(name));
            self.sent = known.map(|(name, mark)| (name.clone(), *mark)).collect();
        }
        // A file that is still being written differs from the look before.
        let is_new = |(name, mark): &(&String, &Mark)| {
            self.sent.get(*name) != Some(*mark) && self.there.get(*name) == Some(*mark)
        };
        look.changed = files.iter().filter(is_new).map(|(name, _)| name.clone()).collect();
        for noted in [&mut self.sent, &mut self.failed] {
            noted.retain(|name, _| files.contains_key(name));
        }
        self.there = files;
        look
    }

    /// Notes that a file was sent, or was not. Returns whether a failure is to be reported: once for each change of the file.
    pub(crate) fn note(&mut self, name: &str, is_sent: bool) -> bool {
        let Some(mark) = self.there.get(name).copied() else { return true };
        let to = if is_sent { &mut self.sent } else { &mut self.failed };
        to.insert(name.to_owned(), mark) != Some(mark)
    }

    /// Returns the first files in the order of their names, and whether there are more.
    fn list(&self) -> std::io::Result<(BTreeMap<String, Mark>, bool)> {
        let mut files = BTreeMap::new();
        let mut is_crowded = false;
        for entry in fs::read_dir(&self.path)? {
            let entry = entry?;
            // A file that is being written has a name that begins with a dot until it is whole.
            let name = entry.file_name().to_str().map(str::to_owned);
            let name = name.filter(|name| !name.starts_with('.'));
            let data = entry.metadata().ok().filter(Metadata::is_file);
            if let (Some(name), Some(data)) = (name, data) {
                files.insert(name, (data.len(), data.modified().ok()));
            }
            if files.len() > MAX_FILES {
                files.pop_last();
                is_crowded = true;
            }
        }
        Ok((files, is_crowded))
    }
}
