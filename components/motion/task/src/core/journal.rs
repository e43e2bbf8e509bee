//! The journal of the job in execution.
//!
//! It has the begin of the job, the answers of the machine, the checksums of the program's files, and the line in
//! execution, at most [`PERIOD`] old. Motion never waits for it.

use super::{Core, Origin, Reading, file_name};
use crate::outside::{Level, Outside};
use hal_gcode::{Answer, Environment, Text, state::State};
use hal_job::{
    effects::Outputs,
    journal::{At, Begin, Record, VERSION},
    world,
};
use hal_output::checksum::Checksum;
use std::{collections::BTreeSet, path::Path};

/// Seconds between two places in the journal.
pub(crate) const PERIOD: f64 = 0.1;
/// Bytes of a file that are read in one step.
const SLICE: usize = 1 << 18;

/// The state of the journal.
#[derive(Default)]
pub(super) struct Keeping {
    is_on: bool,
    last: Option<At>,
    /// The last place of a job that has broken off, while the machine brakes.
    broken: Option<At>,
    /// Time of the last place.
    written: f64,
    /// Names of the files in the journal.
    files: BTreeSet<Box<str>>,
    /// Names of files that a line has entered, and that are not opened yet.
    entered: Vec<Box<str>>,
    hashing: Vec<Hashing>,
}

/// A file whose checksum is being made.
pub(super) struct Hashing {
    pub(super) name: Box<str>,
    text: Text,
    offset: u64,
    sum: Checksum,
}

impl Hashing {
    pub(super) fn new(name: &str, text: Text) -> Self {
        Self { name: name.into(), text, offset: 0, sum: Checksum::default() }
    }

    /// Reads a slice. Returns the checksum at the end of the file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(super) fn advance(&mut self) -> Result<Option<u64>, String> {
        let mut buffer = vec![0; SLICE];
        let read = self.text.read_at(self.offset, &mut buffer);
        let read = read.map_err(|why| format!("{}: {why}", self.name))?;
        self.sum.add(buffer.get(..read).unwrap_or_default());
        self.offset += read as u64;
        Ok((read == 0).then(|| self.sum.value()))
    }
}

impl Keeping {
    /// Notes the files that a line is in: a subroutine may return before the next look at the state.
    pub(super) fn enter(&mut self, state: &State) {
        if !self.is_on {
            return;
        }
        for level in state.levels.iter().rev() {
            // The files of the levels below were noted when these were entered.
            if self.files.contains(&level.file) {
                return;
            }
            self.files.insert(level.file.clone());
            self.entered.push(level.file.clone());
        }
    }
}

impl Core {
    /// Begins the journal of a job, whose interpreter is before its first line.
    pub(super) fn begin_journal(&mut self, path: &Path, outputs: &Outputs, out: &mut impl Outside) {
        self.keeping = Keeping::default();
        let Ok(version) = world::version(path) else { return };
        let state = self.interpreter.state.clone();
        let name = Self::name_of(path);
        let begin = Begin {
            version: VERSION,
            // Another process may begin in another folder.
            path: std::path::absolute(path).unwrap_or_else(|_| path.into()),
            name: name.as_str().into(),
            file: version,
            state,
            outputs: outputs.clone(),
            tools: self.world.machine.tools.clone(),
        };
        self.keeping.is_on = true;
        self.keep(&Record::Begin(Box::new(begin)), out);
        if let Ok(text) = world::program_of(&self.world.machine, path) {
            self.keeping.files.insert(name.as_str().into());
            self.keeping.hashing.push(Hashing::new(&name, text));
        }
    }

    /// Writes a record. A journal that cannot be written ends, and the job goes on.
    fn keep(&mut self, record: &Record, out: &mut impl Outside) {
        if !self.keeping.is_on {
            return;
        }
        if let Err(why) = out.journal(record) {
            self.keeping.is_on = false;
            let text = format!("{why}: the job goes on without a journal");
            self.tell(Level::Error, &text, out);
        }
    }

    /// Writes an answer of the machine.
    pub(super) fn keep_answer(&mut self, answer: &Answer, out: &mut impl Outside) {
        if self.is_program() {
            self.keep(&Record::Answer(answer.clone()), out);
        }
    }

    /// Writes the end of a job that is complete.
    pub(super) fn keep_end(&mut self, out: &mut impl Outside) {
        self.keep(&Record::Complete, out);
        self.keeping.is_on = false;
    }

    /// Writes the last place of a job that breaks off.
    pub(super) fn keep_break(&mut self, out: &mut impl Outside) {
        self.keep_place(true, out);
        self.keeping.broken = self.keeping.last.take_if(|_| self.keeping.is_on);
        self.keeping.is_on = false;
    }

    /// Writes where the machine has come to rest after a break.
    pub(super) fn keep_rest(&mut self, out: &mut impl Outside) {
        let Some(at) = self.keeping.broken.take() else { return };
        let pose = out.motion().pose;
        let rest = beyond(&at, At { pose, gone: 0.0, left: 0.0, ..at.clone() });
        if rest == at {
            return;
        }
        if let Err(why) = out.journal(&Record::At(rest)) {
            self.tell(Level::Error, &format!("{why}: the job has no journal"), out);
        }
    }

    /// Writes what is due: the line in execution, and checksums of files.
    pub(super) fn keep_journal(&mut self, out: &mut impl Outside) {
        if !self.keeping.is_on || !self.is_program() {
            return;
        }
        self.keep_place(false, out);
        for name in core::mem::take(&mut self.keeping.entered) {
            if let Some(text) = self.world.open(&name) {
                self.keeping.hashing.push(Hashing::new(&name, text));
            }
        }
        let Some(hashing) = self.keeping.hashing.last_mut() else { return };
        match hashing.advance() {
            Ok(None) => {}
            Ok(Some(sum)) => {
                let record = Record::File(hashing.name.clone(), sum);
                self.keeping.hashing.pop();
                self.keep(&record, out);
            }
            // The program itself reports what is wrong with its file.
            Err(_) => drop(self.keeping.hashing.pop()),
        }
    }

    fn keep_place(&mut self, now: bool, out: &mut impl Outside) {
        if !self.keeping.is_on || !self.is_program() {
            return;
        }
        // Between two places, nothing is looked for.
        if !now && out.now() - self.keeping.written < PERIOD {
            return;
        }
        let (number, line) = self.unfinished();
        let motion = out.motion();
        let at = At {
            number,
            line,
            file: self.unfinished_file(),
            pose: motion.pose,
            gone: motion.travelled,
            left: motion.to_go,
            homed: motion.all_homed,
            tool: out.io().tool,
        };
        let at = match self.keeping.last.as_ref().filter(|_| now) {
            Some(last) => beyond(last, at),
            None => at,
        };
        if self.keeping.last.as_ref() != Some(&at) {
            self.keeping.written = out.now();
            self.keep(&Record::At(at.clone()), out);
            self.keeping.last = Some(at);
        }
    }

    fn is_program(&self) -> bool {
        self.job.as_ref().is_some_and(|job| job.is_program)
    }

    /// Returns the origin of the first step that is not finished.
    fn first_unfinished(&self) -> Option<&Origin> {
        let current = self.current.as_ref().filter(|_| self.waiting.is_some());
        let flight = self.flight.front().map(|f| &f.origin);
        flight.or(current).or(self.queue.front().map(|e| &e.origin))
    }

    /// Returns the file of the line that [`Self::unfinished`] returns.
    fn unfinished_file(&self) -> Box<str> {
        let level = self.interpreter.state.levels.last().map(|level| &level.file);
        let origin = self.first_unfinished().map(|origin| &origin.tag.file);
        origin.or(level).cloned().unwrap_or_default()
    }

    /// Returns the number of lines that are executed, and the line behind them.
    pub(super) fn unfinished(&self) -> (u64, u32) {
        if let Some(origin) = self.first_unfinished() {
            return (origin.number, origin.line);
        }
        let state = &self.interpreter.state;
        match self.job.as_ref().map(|job| &job.reading) {
            Some(Reading::Asked(_)) => (state.lines_run.saturating_sub(1), state.line),
            _ => (state.lines_run, state.levels.last().map_or(state.line, |l| l.cursor.line + 1)),
        }
    }
}

/// Returns a place in a job whose motion has no move any more, as one on the move of the place before.
fn beyond(before: &At, at: At) -> At {
    let has_move = at.gone > 0.0 || at.left > 0.0;
    let had_move = before.gone > 0.0 || before.left > 0.0;
    if has_move || !had_move || at.number != before.number {
        return at;
    }
    let by = distance(&before.pose, &at.pose);
    let left = if by < before.left { before.left - by } else { 0.0 };
    At { gone: before.gone + by, left, ..at }
}

/// Returns the distance between two poses in X Y Z; without one, in U V W, and without that, in A B C.
fn distance(from: &[f64; 9], to: &[f64; 9]) -> f64 {
    let along = |axes: [usize; 3]| {
        let by = axes.map(|n| to.get(n).zip(from.get(n)).map_or(0.0, |(a, b)| a - b));
        by.iter().map(|d| d * d).sum::<f64>().sqrt()
    };
    [[0, 1, 2], [6, 7, 8], [3, 4, 5]].map(along).into_iter().find(|d| *d > 0.0).unwrap_or(0.0)
}

/// Returns the text that names a changed file.
pub(super) fn changed(path: &Path) -> String {
    format!("{}: the program has changed since the job began", file_name(path))
}
