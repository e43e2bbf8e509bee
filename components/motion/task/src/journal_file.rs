//! The file of the journal.
//!
//! A new journal replaces the old one as a whole. Its records are added to the end, and a thread of its own stores them
//! on the disk, so that the worker never waits for the disk.

use hal_job::journal::Record;
use hal_output::Growing;
use std::{
    fs::File,
    path::{Path, PathBuf},
    sync::mpsc::{SyncSender, sync_channel},
};

/// Largest journal in bytes.
const MAX_LEN: u64 = 1 << 28;

/// The file of the journal, and the thread that stores it.
#[derive(Default)]
pub(crate) struct JournalFile {
    path: Option<PathBuf>,
    open: Option<(Growing, SyncSender<()>)>,
}

impl JournalFile {
    pub(crate) fn new(path: Option<PathBuf>) -> Self {
        Self { path, open: None }
    }

    /// Writes a record; the begin of a job begins a new file. A file that cannot be written is removed, because an old
    /// journal is not that of the job.
    ///
    /// # Errors
    /// The file cannot be written; its name and the reason.
    pub(crate) fn write(&mut self, record: &Record) -> Result<(), String> {
        let Some(path) = self.path.clone() else { return Ok(()) };
        let line = record.line();
        let result = match (record, &mut self.open) {
            (Record::Begin(_), _) => begin(&path, &line).map(|open| self.open = Some(open)),
            (_, Some((file, store))) => file.append(line.as_bytes()).map(|()| {
                // A full channel has the thread store this record, too.
                store.try_send(()).unwrap_or_default();
            }),
            (_, None) => Ok(()),
        };
        result.map_err(|e| {
            self.open = None;
            std::fs::remove_file(&path).unwrap_or_default();
            format!("{}: {}", path.display(), hal_output::reason(&e))
        })
    }

    /// Reads the file.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    pub(crate) fn read(&self) -> Result<Vec<u8>, String> {
        let path =
            self.path.as_deref().ok_or("there is no journal: the machine has no INI file")?;
        let wrong = |why: &str| format!("{}: {why}", path.display());
        let bytes = hal_ini::file::contents(path, MAX_LEN);
        let bytes = bytes.map_err(|e| wrong(&hal_output::reason(&e)))?;
        bytes.ok_or_else(|| wrong("it is no journal: it is larger than 256 MiB"))
    }
}

/// Replaces the file by one with this line, and starts the thread that stores what follows.
fn begin(path: &Path, line: &str) -> std::io::Result<(Growing, SyncSender<()>)> {
    let mut file = Growing::create(path)?;
    file.append(line.as_bytes())?;
    let stored = File::open(path)?;
    let (store, due) = sync_channel(1);
    store.try_send(()).unwrap_or_default();
    std::thread::Builder::new().name("journal".to_owned()).spawn(move || {
        while due.recv().is_ok() {
            // The next record is stored with this one, or a later write reports the disk.
            stored.sync_data().unwrap_or_default();
        }
    })?;
    Ok((file, store))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_job::journal::{At, Journal};

    #[test]
    fn a_disk_that_is_full_leaves_no_journal() {
        // Every write to this device fails as on a full disk.
        let full = Growing::create(Path::new("/dev/full")).unwrap();
        let path = std::env::temp_dir().join(format!("hal-journal-{}", std::process::id()));
        std::fs::write(&path, "old").unwrap();
        let (store, _due) = sync_channel(1);
        let mut journal = JournalFile { path: Some(path.clone()), open: Some((full, store)) };
        let at = At { number: 1, line: 1, pose: [0.0; 9], homed: true, tool: 0 };
        let why = journal.write(&Record::At(at.clone())).unwrap_err();
        assert!(why.ends_with(": No space left on device"), "{why}");
        assert!(!path.exists(), "what is old is not the job's");
        assert!(journal.read().unwrap_err().contains("No such file"));
        assert_eq!(journal.write(&Record::At(at)), Ok(()), "later records are dropped");
        assert!(!path.exists());
        assert!(JournalFile::default().read().unwrap_err().contains("no INI file"));
        assert!(Journal::parse(b"").is_err());
    }
}
