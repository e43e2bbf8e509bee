//! The file of the journal.
//!
//! A new journal replaces the old one as a whole, and is on the disk before it does. Its records are added to the end, and
//! a thread of its own stores them on the disk, so that the worker waits for the disk at the beginning of a file only. Places
//! of a long job are superfluous but for the last one: from time to time a shorter journal replaces the file.

use hal_job::journal::Record;
use hal_output::Growing;
use std::{
    fs::File,
    io,
    path::{Path, PathBuf},
    sync::mpsc::{SyncSender, sync_channel},
};

/// Largest journal in bytes.
const MAX_LEN: u64 = 1 << 28;
/// Length of the places in bytes, from which the journal is written again without them.
const MAX_PLACES: u64 = 1 << 24;

/// The file of the journal, and the thread that stores it.
#[derive(Default)]
pub(crate) struct JournalFile {
    path: Option<PathBuf>,
    open: Option<Open>,
}

/// A journal that is being written.
struct Open {
    file: Growing,
    store: SyncSender<()>,
    /// Every record but places.
    kept: String,
    /// The last place.
    place: String,
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
            (Record::Begin(_), _) => {
                begin(&path, line, String::new(), MAX_LEN).map(|open| self.open = Some(open))
            }
            (_, Some(open)) => open.add(&path, record, &line, (MAX_PLACES, MAX_LEN)),
            (_, None) => Ok(()),
        };
        result.map_err(|e| {
            self.open = None;
            let why = format!("{}: {}", path.display(), hal_output::reason(&e));
            match std::fs::remove_file(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => {
                    let reason = hal_output::reason(&e);
                    format!("{why}; the old journal cannot be removed ({reason}): remove it")
                }
                _ => why,
            }
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

impl Open {
    /// Adds a record; `bounds` are the largest length of the places and of the journal.
    fn add(
        &mut self,
        path: &Path,
        record: &Record,
        line: &str,
        bounds: (u64, u64),
    ) -> io::Result<()> {
        if matches!(record, Record::At(_)) {
            line.clone_into(&mut self.place);
        } else {
            self.kept.push_str(line);
        }
        let kept = self.kept.len() as u64;
        if self.file.bytes().saturating_sub(kept) > bounds.0 {
            let (kept, place) = (&mut self.kept, &mut self.place);
            *self = begin(path, core::mem::take(kept), core::mem::take(place), bounds.1)?;
            return Ok(());
        }
        if self.file.bytes() + line.len() as u64 > bounds.1 {
            return Err(too_long());
        }
        self.file.append(line.as_bytes())?;
        // A full channel has the thread store this record, too.
        self.store.try_send(()).unwrap_or_default();
        Ok(())
    }
}

/// Replaces the file by one with these records and a place, and starts the thread that stores what follows.
fn begin(path: &Path, kept: String, place: String, bound: u64) -> io::Result<Open> {
    if (kept.len() + place.len()) as u64 > bound {
        return Err(too_long());
    }
    let file = Growing::create_stored(path, format!("{kept}{place}").as_bytes())?;
    let stored = File::open(path)?;
    let (store, due) = sync_channel(1);
    store.try_send(()).unwrap_or_default();
    std::thread::Builder::new().name("journal".to_owned()).spawn(move || {
        while due.recv().is_ok() {
            // The next record is stored with this one, or a later write reports the disk.
            stored.sync_data().unwrap_or_default();
        }
    })?;
    Ok(Open { file, store, kept, place })
}

fn too_long() -> io::Error {
    io::Error::other("the answers of the machine fill 256 MiB")
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_job::journal::{At, Journal};

    fn at(number: u64) -> At {
        At {
            number,
            line: 1,
            file: "job.ngc".into(),
            pose: [0.0; 9],
            gone: 0.0,
            left: 0.0,
            homed: true,
            tool: 0,
        }
    }

    #[test]
    fn a_disk_that_is_full_leaves_no_journal() {
        // Every write to this device fails as on a full disk.
        let full = Growing::create(Path::new("/dev/full")).unwrap();
        let path = std::env::temp_dir().join(format!("hal-journal-{}", std::process::id()));
        std::fs::write(&path, "old").unwrap();
        let (store, _due) = sync_channel(1);
        let open = Open { file: full, store, kept: String::new(), place: String::new() };
        let mut journal = JournalFile { path: Some(path.clone()), open: Some(open) };
        let at = at(1);
        let why = journal.write(&Record::At(at.clone())).unwrap_err();
        assert!(why.ends_with(": No space left on device"), "{why}");
        assert!(!path.exists(), "what is old is not the job's");
        assert!(journal.read().unwrap_err().contains("No such file"));
        assert_eq!(journal.write(&Record::At(at)), Ok(()), "later records are dropped");
        assert!(!path.exists());
        assert!(JournalFile::default().read().unwrap_err().contains("no INI file"));
        assert!(Journal::parse(b"").is_err());
    }

    #[test]
    fn an_old_journal_that_stays_is_named() {
        let path = std::env::temp_dir().join(format!("hal-journal-kept-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        let full = Growing::create(Path::new("/dev/full")).unwrap();
        let (store, _due) = sync_channel(1);
        let open = Open { file: full, store, kept: String::new(), place: String::new() };
        let mut journal = JournalFile { path: Some(path.clone()), open: Some(open) };
        let why = journal.write(&Record::Complete).unwrap_err();
        std::fs::remove_dir(&path).unwrap();
        let shown = path.display();
        assert!(
            why.starts_with(&format!(
                "{shown}: No space left on device; the old journal cannot be removed ("
            )),
            "{why}"
        );
    }

    #[test]
    fn a_long_job_has_a_short_journal_with_its_last_place() {
        let path = std::env::temp_dir().join(format!("hal-journal-long-{}", std::process::id()));
        let first = Record::File("job.ngc".into(), 7).line();
        let mut open = begin(&path, first.clone(), String::new(), 10_000).unwrap();
        let place = |number| Record::At(at(number));
        let answer = Record::Answer(hal_gcode::Answer::Input(1.0));
        for number in 0..1000 {
            let record = place(number);
            open.add(&path, &record, &record.line(), (1000, 10_000)).unwrap();
            if number % 100 == 0 {
                open.add(&path, &answer, &answer.line(), (1000, 10_000)).unwrap();
            }
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.len() < 3500, "{number}: {} bytes", text.len());
            let answers = text.lines().filter(|line| line.contains("Answer")).count() as u64;
            assert_eq!(answers, number / 100 + 1, "every answer is kept");
            assert!(text.starts_with(&first) && text.contains(&place(number).line()), "{number}");
        }
        // An answer, too, has the file written again.
        let last = place(1000);
        open.add(&path, &last, &last.line(), (u64::MAX, u64::MAX)).unwrap();
        open.add(&path, &answer, &answer.line(), (0, 10_000)).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().filter(|line| line.contains("At")).count(), 1, "{text}");
        assert!(text.contains(&last.line()), "{text}");
        let why =
            (0..1000).find_map(|_| open.add(&path, &answer, &answer.line(), (1000, 10_000)).err());
        std::fs::remove_file(&path).unwrap();
        assert!(why.unwrap().to_string().contains("the answers of the machine fill"));
    }
}
