//! Events that the flight recorder has kept, and the writing of their files.

use super::history::History;
use crate::{Error, error::watch::WatchError, os};
use hal_output::Whole;
use hal_protocol::{KeptInfo, KeptState};
use hal_trace::{FileError, Format, Refusal, Trace};
use std::{path::Path, sync::Arc, thread::JoinHandle};

/// Contents of the recorder at an event, with marks.
#[derive(Debug)]
pub(super) struct Snapshot {
    pub(super) history: History,
    pub(super) to: i64,
    pub(super) marks: Vec<(i64, String)>,
}

impl Snapshot {
    fn trace(&self) -> Result<Trace, Refusal> {
        let mut trace = self.history.trace(self.to)?;
        self.marks.iter().for_each(|(at, text)| trace.mark(*at, text));
        Ok(trace)
    }

    fn write(&self, mut file: Whole, format: Format) -> Result<(), Box<str>> {
        let trace = self.trace().map_err(|e| e.to_string())?;
        let written = format.write(&mut file, &trace).and_then(|()| file.finish());
        written.map_err(|e| os::said(&e))
    }
}

/// Event that has been kept.
#[derive(Debug)]
pub(super) struct Kept {
    pub(super) info: KeptInfo,
    writer: Option<JoinHandle<Result<(), Box<str>>>>,
    /// True if the recorder kept it because of an event, false if a user asked for it.
    pub(super) is_event: bool,
    /// Number of changes that are missing in it because the queue was full.
    pub(super) lost: u64,
}

impl Kept {
    pub(super) const fn new(info: KeptInfo, is_event: bool) -> Self {
        Self { info, writer: None, is_event, lost: 0 }
    }

    /// Writes the file, in a separate thread unless `at_once`.
    pub(super) fn write(
        &mut self,
        snapshot: &Arc<Snapshot>,
        file: Whole,
        format: Format,
        at_once: bool,
    ) {
        if at_once {
            self.have_written(snapshot.write(file, format));
            return;
        }
        self.info.state = KeptState::Writing;
        let snapshot = snapshot.clone();
        let named = std::thread::Builder::new().name("hal-flight".into());
        match named.spawn(move || snapshot.write(file, format)) {
            Ok(writer) => self.writer = Some(writer),
            Err(e) => self.info.state = KeptState::Failed(os::said(&e).into()),
        }
    }

    /// Returns whether this is an event that could not be written whole.
    pub(super) const fn is_unwritten(&self) -> bool {
        let failed = matches!(self.info.state, KeptState::Failed(_));
        self.is_event && (failed || self.lost > 0 && self.info.file.is_some())
    }

    /// Checks whether the file is written, waiting for it if `wait`. Returns whether the writing
    /// has just ended.
    pub(super) fn look(&mut self, wait: bool) -> bool {
        let Some(writer) = self.writer.take_if(|w| wait || w.is_finished()) else { return false };
        let done = writer.join();
        self.have_written(done.unwrap_or_else(|_| Err("its writer has failed".into())));
        true
    }

    fn have_written(&mut self, done: Result<(), Box<str>>) {
        self.info.state = match done {
            Ok(()) => KeptState::Written,
            Err(why) => KeptState::Failed(why.into()),
        };
    }

    /// Returns the message about it. `ends`: the recorder is being switched off, and what is only
    /// in memory is lost.
    pub(super) fn words(&self, ends: bool) -> String {
        let (number, why) = (self.info.number, &self.info.why);
        let file = self.info.file.as_deref().unwrap_or_default();
        let ending = file.rsplit_once('.').map_or("vcd", |(_, ending)| ending);
        let kept = match &self.info.state {
            KeptState::Written => format!("kept in {file}"),
            KeptState::Failed(e) if ends => format!("{file}: {e}; it is lost"),
            KeptState::Failed(e) => {
                format!("{file}: {e}; it is in memory: 'flight save FILE.{ending} last'")
            }
            _ if ends => "it is lost: 'flight on' was given no file=".to_owned(),
            _ => format!("kept in memory as event {number}"),
        };
        let lost = match self.lost {
            0 => String::new(),
            lost => format!("; {lost} changes were lost for want of room"),
        };
        format!("flight recorder: {why}; {kept}{lost}")
    }
}

/// Returns the format of a file, according to the extension of its name.
pub(super) fn format_of(path: &str) -> Result<Format, Error> {
    let path = Path::new(path);
    let ending = || WatchError::Ending { said: FileError::Ending(path.into()).to_string().into() };
    Format::of(path).ok_or_else(|| ending().into())
}

/// Creates a file that replaces an existing one only when the snapshot is completely written. A pipe that nobody reads
/// is refused, so that it holds up neither the control side nor the end of the process.
pub(super) fn create(path: &str) -> Result<Whole, Error> {
    Whole::create_promptly(Path::new(path))
        .map_err(|e| Error::File { path: path.into(), why: os::said(&e) })
}

/// Returns the name of the file of an event: `DIR/NAME-3.ENDING`.
pub(super) fn numbered(path: &str, number: u32) -> String {
    match path.rsplit_once('.') {
        Some((name, ending)) => format!("{name}-{number}.{ending}"),
        None => format!("{path}-{number}"),
    }
}
