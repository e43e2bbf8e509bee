//! The journal of a job: what a job needs to go on after the machine has lost its power.
//!
//! A journal is a text. Each line has a checksum and a record in JSON. A line that was cut off, or that a disk has
//! lost, ends the journal there: the records before it count.

use crate::{effects::Outputs, world::Version};
use hal_gcode::{Answer, State, tool::ToolTable};
use hal_output::checksum;
use serde::{Deserialize, Serialize};
use std::{fmt, path::PathBuf};

/// Version of the records.
pub const VERSION: u32 = 3;

/// A record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Record {
    /// A job begins.
    Begin(Box<Begin>),
    /// The machine has answered a question of the program.
    Answer(Answer),
    /// The text of a file of the program: its name in the program, and its checksum.
    File(Box<str>, u64),
    /// The line in execution: every line before it has been executed.
    At(At),
    /// The job has ended.
    Complete,
}

/// The begin of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Begin {
    /// Version of the records.
    pub version: u32,
    /// The program's file.
    pub path: PathBuf,
    /// The program's name in the interpreter.
    pub name: Box<str>,
    /// Size and time of change of the program.
    pub file: Version,
    /// State of the interpreter before the job's first line.
    pub state: State,
    /// Outputs that the program has set before that line.
    pub outputs: Outputs,
    /// The tool table.
    pub tools: ToolTable,
}

/// A place in a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct At {
    /// Number of lines before the line in execution.
    pub number: u64,
    /// The line, from 1.
    pub line: u32,
    /// The file of the line.
    pub file: Box<str>,
    /// Commanded place in machine units.
    pub pose: [f64; 9],
    /// Distance in machine units travelled along the move in execution.
    pub gone: f64,
    /// Distance in machine units to its end; 0 without a move.
    pub left: f64,
    /// Every joint was homed.
    pub homed: bool,
    /// The tool in the spindle.
    pub tool: i32,
}

/// The state of a job that its journal holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Journal {
    /// The begin of the job.
    pub begin: Box<Begin>,
    /// The answers of the machine.
    pub answers: Vec<Answer>,
    /// The checksums of the program's files, by their names in the program.
    pub files: Vec<(Box<str>, u64)>,
    /// The last place.
    pub at: Option<At>,
    /// The job has ended.
    pub is_complete: bool,
    /// The end of the journal was lost.
    pub is_cut: bool,
}

/// Reason for which a journal is of no use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unusable {
    /// No whole record of a job's begin.
    NoBegin,
    /// Another version of the records.
    Version(u32),
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoBegin => f.write_str("the journal has no job"),
            Self::Version(version) => {
                write!(f, "the journal has version {version}, must be {VERSION}")
            }
        }
    }
}

impl Record {
    /// Returns the record's line in the journal.
    pub fn line(&self) -> String {
        // Records have text keys only, so that JSON has a form for each.
        let json = serde_json::to_string(self).unwrap_or_default();
        format!("{:016x} {json}\n", checksum::of(json.as_bytes()))
    }

    /// Parses a line without its end; `None` if it is not whole.
    fn parse(line: &[u8]) -> Option<Self> {
        let line = core::str::from_utf8(line).ok()?;
        let (sum, json) = line.split_once(' ')?;
        let sum = u64::from_str_radix(sum, 16).ok()?;
        if sum != checksum::of(json.as_bytes()) {
            return None;
        }
        serde_json::from_str(json).ok()
    }
}

impl Journal {
    /// Reads the text of a journal.
    ///
    /// # Errors
    /// It has no job.
    pub fn parse(text: &[u8]) -> Result<Self, Unusable> {
        let mut lines = text.split_inclusive(|b| *b == b'\n');
        let whole = |line: &[u8]| line.strip_suffix(b"\n").and_then(Record::parse);
        let Some(Record::Begin(begin)) = lines.next().and_then(whole) else {
            return Err(Unusable::NoBegin);
        };
        if begin.version != VERSION {
            return Err(Unusable::Version(begin.version));
        }
        let mut out = Self {
            begin,
            answers: Vec::new(),
            files: Vec::new(),
            at: None,
            is_complete: false,
            is_cut: false,
        };
        for line in lines {
            match whole(line) {
                Some(Record::Answer(answer)) => out.answers.push(answer),
                Some(Record::File(name, hash)) => out.files.push((name, hash)),
                Some(Record::At(at)) => out.at = Some(at),
                Some(Record::Complete) => out.is_complete = true,
                Some(Record::Begin(_)) | None => {
                    out.is_cut = true;
                    break;
                }
            }
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_gcode::{Interpreter, Numbered, Settings};

    fn journal() -> Vec<Record> {
        let mut it = Interpreter::new(Settings::default(), Numbered::default());
        it.load("job.ngc", std::sync::Arc::new(b"G0 X1\nM2\n".to_vec()));
        let begin = Begin {
            version: VERSION,
            path: "/tmp/job.ngc".into(),
            name: "job.ngc".into(),
            file: (9, 0, 0),
            state: it.state,
            outputs: Outputs::default(),
            tools: ToolTable::parse("T1 P1 Z2\n").0,
        };
        let at = |number| {
            Record::At(At {
                number,
                line: 2,
                file: "job.ngc".into(),
                pose: [0.1; 9],
                gone: 1.5,
                left: 2.5,
                homed: true,
                tool: 3,
            })
        };
        vec![
            Record::Begin(Box::new(begin)),
            Record::File("job.ngc".into(), 77),
            at(1),
            Record::Answer(Answer::Input(1.5)),
            at(2),
        ]
    }

    #[test]
    fn a_journal_cut_at_any_byte_has_the_records_before() {
        let records = journal();
        let lines: Vec<String> = records.iter().map(Record::line).collect();
        let text = lines.concat();
        let first = lines[0].len();
        for end in 0..=text.len() {
            let read = Journal::parse(&text.as_bytes()[..end]);
            if end < first {
                assert_eq!(read, Err(Unusable::NoBegin));
                continue;
            }
            let journal = read.unwrap();
            let mut whole = 0;
            let mut count = 0;
            while count < lines.len() && whole + lines[count].len() <= end {
                whole += lines[count].len();
                count += 1;
            }
            assert_eq!(journal.is_cut, end != whole, "{end}");
            let known = &records[..count];
            let last = known.iter().rev().find_map(|r| match r {
                Record::At(at) => Some(at.clone()),
                _ => None,
            });
            assert_eq!(journal.at, last, "{end}");
            let answers = known.iter().filter(|r| matches!(r, Record::Answer(_))).count();
            assert_eq!((journal.answers.len(), journal.is_complete), (answers, false));
            let Record::Begin(begin) = &records[0] else { panic!() };
            assert_eq!(*journal.begin, **begin);
        }
    }

    #[test]
    fn a_changed_byte_ends_the_journal_before_its_line() {
        let lines: Vec<String> = journal().iter().map(Record::line).collect();
        let text = lines.concat().into_bytes();
        let last = text.len() - lines[4].len();
        for at in last..text.len() {
            let mut text = text.clone();
            text[at] ^= 1;
            let journal = Journal::parse(&text).unwrap();
            assert!(journal.is_cut, "byte {at}");
            assert_eq!(journal.at.unwrap().number, 1);
        }
    }
}
