//! The medium as the simulated controller sees it: a worker reads images and programs, and passes steps to the function.

use crate::packed;
use hal_component::{
    Builder, Error, In, Messages, Plain, RingReader, RingWriter, SeqReader, SeqWriter, Texts,
    Touch, Work,
};
use hal_nk105::{
    JobStep, JobStop, Medium, WrongJob, controller::Next, job::read, motion::TRAVEL,
    panel::ScreenRow,
};
use hal_storage::{Side, image, storage::MOST_BYTES};
use std::{collections::VecDeque, fs::File, path::PathBuf};

/// Largest number of files in the menu.
const MAX_FILES: usize = 64;
/// Number of steps that wait for the function.
const STEPS: usize = 1024;
/// Period of the worker, in nanoseconds.
const PERIOD_NS: i64 = 10_000_000;

/// Files of a medium.
#[derive(Clone, Copy, Plain)]
struct FileList {
    /// Number of the medium: 0 none, 1 image A, 2 image B.
    medium: i32,
    /// Number of the change of medium that it is about.
    count: u32,
    /// First 16 bytes of each name, eight in a word, the first in the lowest byte.
    names: [u64; 2 * MAX_FILES],
}

/// Request of the function.
#[derive(Clone, Copy, Plain)]
struct OpenJob {
    /// Number of the job, from 1; 0 closes the job.
    job: u32,
    /// Index of the file.
    index: u32,
    /// Zero of the work in machine coordinates, in millimetres.
    origin: [f64; 3],
}

/// Step of a job on its way to the function.
#[derive(Clone, Copy, Plain)]
struct StepRecord {
    /// Number of the job.
    job: u32,
    /// Kind of the step.
    kind: u32,
    /// Coordinates in millimetres, or other numbers of the step.
    numbers: [f64; 4],
}

const LINE: u32 = 0;
const DWELL: u32 = 1;
const TOOL: u32 = 2;
const SPINDLE: u32 = 3;
const PAUSE: u32 = 4;
const END: u32 = 5;
const UNREADABLE: u32 = 6;
const WRONG_LINE: u32 = 7;
const BEYOND: u32 = 8;
const GONE: u32 = 9;

/// The function's end.
#[derive(Touch)]
pub(crate) struct SimMedium {
    medium: In<i32>,
    list: SeqReader<FileList>,
    asks: RingWriter<OpenJob>,
    steps: RingReader<StepRecord>,
    #[state]
    job: u32,
    /// Request for which there was no room yet.
    #[state]
    asking: Option<OpenJob>,
}

impl SimMedium {
    fn is_plugged(&self) -> bool {
        matches!(self.medium.get(), 1 | 2)
    }

    fn ask(&mut self) {
        if let Some(asking) = self.asking
            && self.asks.put(asking).is_ok()
        {
            self.asking = None;
        }
    }
}

/// Declares the worker, and returns the function's end.
///
/// # Errors
/// A name is taken.
pub(crate) fn declare(b: &mut Builder<'_>, folder: &str) -> Result<SimMedium, Error> {
    let doc = "Medium that is plugged in: 0 none, 1 image A, 2 image B.";
    let medium = b.item("sim-nk105.medium", doc, 0)?;
    let empty = FileList { medium: 0, count: 0, names: [0; 2 * MAX_FILES] };
    let (list_writer, list) = b.seqlock(empty);
    let (asks, asked) = b.ring(16);
    let (given, steps) = b.ring(STEPS);
    let host = Host {
        medium,
        folder: PathBuf::from(folder),
        list: list_writer,
        asked,
        given,
        listed: None,
        names: Vec::new(),
        waiting: VecDeque::new(),
        texts: Texts::new(1000),
        messages: b.messages(),
    };
    b.worker("sim-nk105.host", "Reads the medium and its programs.", PERIOD_NS, 400, host)?;
    Ok(SimMedium { medium, list, asks, steps, job: 0, asking: None })
}

impl Medium for SimMedium {
    fn files(&mut self) -> Option<u32> {
        if !self.is_plugged() {
            return None;
        }
        let list = self.list.get();
        (list.medium == self.medium.get()).then_some(list.count)
    }

    fn name(&mut self, index: u32) -> ScreenRow {
        let list = self.list.get();
        let at = usize::try_from(index).unwrap_or(usize::MAX).saturating_mul(2);
        let words = list.names.get(at..at.saturating_add(2)).unwrap_or_default();
        let mut row = ScreenRow::default();
        packed::bytes(words).filter(|byte| *byte != 0).for_each(|byte| row.push(byte));
        row
    }

    fn open(&mut self, index: u32, origin: [f64; 3]) {
        self.job = self.job.wrapping_add(1).max(1);
        self.asking = Some(OpenJob { job: self.job, index, origin });
    }

    fn next(&mut self) -> Next {
        self.ask();
        if !self.is_plugged() {
            return Next::Failed(JobStop::NoMedium);
        }
        // Steps of a job that was stopped are still on their way.
        for _ in 0..STEPS {
            let Some(record) = self.steps.take() else { return Next::Later };
            if record.job == self.job {
                return next(&record);
            }
        }
        Next::Later
    }

    fn close(&mut self) {
        self.job = self.job.wrapping_add(1).max(1);
        self.asking = Some(OpenJob { job: 0, index: 0, origin: [0.0; 3] });
        self.ask();
    }
}

fn next(record: &StepRecord) -> Next {
    let [x, y, z, feed] = record.numbers;
    #[expect(clippy::cast_possible_truncation, reason = "a tool or a line that was an integer")]
    let number = x as i32;
    let line = u32::try_from(number).unwrap_or(0);
    match record.kind {
        LINE => Next::Step(JobStep::Line([x, y, z], feed)),
        DWELL => Next::Step(JobStep::Dwell(x)),
        TOOL => Next::Step(JobStep::Tool(number)),
        SPINDLE => Next::Step(JobStep::Spindle(x != 0.0)),
        PAUSE => Next::Step(JobStep::Pause),
        END => Next::End,
        WRONG_LINE => Next::Failed(JobStop::Line(line)),
        BEYOND => Next::Failed(JobStop::Travel(line)),
        GONE => Next::Failed(JobStop::NoMedium),
        _ => Next::Failed(JobStop::Unreadable),
    }
}

/// Worker that reads the medium.
#[derive(Touch)]
struct Host {
    medium: In<i32>,
    #[state]
    folder: PathBuf,
    list: SeqWriter<FileList>,
    asked: RingReader<OpenJob>,
    given: RingWriter<StepRecord>,
    /// Medium whose files are listed.
    #[state]
    listed: Option<i32>,
    #[state]
    names: Vec<String>,
    #[state]
    waiting: VecDeque<StepRecord>,
    #[state]
    texts: Texts,
    messages: Messages,
}

impl Work for Host {
    fn work(&mut self, items: u32) -> u32 {
        let medium = self.medium.get();
        if self.listed != Some(medium) {
            self.look(medium);
        }
        while let Some(ask) = self.asked.take() {
            self.waiting.clear();
            if ask.job != 0 {
                self.open(&ask);
            }
        }
        for done in 0..items {
            let Some(record) = self.waiting.front() else { return done };
            if self.given.put(*record).is_err() {
                return done;
            }
            self.waiting.pop_front();
        }
        items
    }
}

impl Host {
    fn image(&self, medium: i32) -> Option<std::io::Result<File>> {
        let side = match medium {
            1 => Side::A,
            2 => Side::B,
            _ => return None,
        };
        // The crate for FAT wants to write; it changes nothing here.
        Some(File::options().read(true).write(true).open(self.folder.join(side.file())))
    }

    /// Lists the files of a medium.
    fn look(&mut self, medium: i32) {
        self.listed = Some(medium);
        self.names.clear();
        match self.image(medium).map(|file| file.and_then(image::list)) {
            None => {}
            Some(Ok(files)) => self.names.extend(files.into_iter().take(MAX_FILES).map(|f| f.name)),
            Some(Err(e)) => {
                let text = self.texts.keep(&format!("the medium cannot be read: {e}"));
                self.messages.error(text, &[]);
            }
        }
        let mut list = FileList { medium, count: 0, names: [0; 2 * MAX_FILES] };
        for (name, words) in self.names.iter().zip(list.names.chunks_exact_mut(2)) {
            list.count += 1;
            words.copy_from_slice(&packed::words::<2>(name.as_bytes()));
        }
        self.list.set(&list);
    }

    fn open(&mut self, ask: &OpenJob) {
        let image = self.listed.and_then(|medium| self.image(medium));
        let mut put = |kind, numbers| {
            self.waiting.push_back(StepRecord { job: ask.job, kind, numbers });
        };
        let Some(image) = image else {
            put(GONE, [0.0; 4]);
            return;
        };
        let name = usize::try_from(ask.index).ok().and_then(|at| self.names.get(at));
        let name = name.map_or("", String::as_str);
        let text = match image.and_then(|disk| image::read(disk, name, MOST_BYTES)) {
            Ok(text) => text,
            Err(e) => {
                put(UNREADABLE, [0.0; 4]);
                let text = self.texts.keep(&format!("{name} cannot be read: {e}"));
                self.messages.error(text, &[]);
                return;
            }
        };
        match read(&text, ask.origin, TRAVEL) {
            Ok(steps) => {
                for step in steps {
                    match step {
                        JobStep::Line([x, y, z], feed) => put(LINE, [x, y, z, feed]),
                        JobStep::Dwell(s) => put(DWELL, [s, 0.0, 0.0, 0.0]),
                        JobStep::Tool(n) => put(TOOL, [f64::from(n), 0.0, 0.0, 0.0]),
                        JobStep::Spindle(on) => {
                            put(SPINDLE, [f64::from(u8::from(on)), 0.0, 0.0, 0.0]);
                        }
                        JobStep::Pause => put(PAUSE, [0.0; 4]),
                    }
                }
                put(END, [0.0; 4]);
            }
            Err(why) => {
                let kind = if matches!(why, WrongJob::Travel(_)) { BEYOND } else { WRONG_LINE };
                put(kind, [f64::from(why.line()), 0.0, 0.0, 0.0]);
                let text = self.texts.keep(&format!("{name}: {why}"));
                self.messages.error(text, &[]);
            }
        }
    }
}
