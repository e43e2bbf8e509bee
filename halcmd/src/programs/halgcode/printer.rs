//! Canonical calls as `rs274` prints them: numbered, with the N number of their line.

use crate::{Stdio, Terminal};
use hal_gcode::{Call, Interpreter, Issued};
use hal_job::run::Stop;
use hal_output::Whole;
use std::{
    fmt::Write as _,
    io::Write as _,
    path::{Path, PathBuf},
};

/// Numbers calls and writes them.
pub(super) struct Printer {
    count: u64,
    text: String,
    file: Option<(PathBuf, Whole)>,
    lines: bool,
}

impl Printer {
    pub(super) fn new(path: Option<&Path>, lines: bool) -> Result<Self, String> {
        let file = match path {
            None => None,
            Some(p) => {
                let file = Whole::create(p);
                let file =
                    file.map_err(|e| format!("{}: {}", p.display(), hal_output::reason(&e)))?;
                Some((p.to_path_buf(), file))
            }
        };
        Ok(Self { count: 0, text: String::new(), file, lines })
    }

    pub(super) fn issued(&mut self, it: &Interpreter, issued: &Issued) -> Result<(), Stop> {
        if self.lines && !matches!(issued.call, Call::Wait { .. }) {
            self.place(it, issued);
        }
        let written = match &issued.call {
            // The reference does not print it.
            Call::Wait { .. } => Ok(()),
            Call::Print(text) => {
                self.flush()?;
                Stdio.out(&format!("{text}\n")).map_err(String::from)
            }
            call => self.call(call, issued.number),
        };
        written.map_err(Stop::Output)
    }

    /// Writes the place of a call: file, line, the lines of the calls around it, and the pass of its loop.
    fn place(&mut self, it: &Interpreter, issued: &Issued) {
        let levels = &it.state.levels;
        let file = levels.last().map(|l| &*l.file).unwrap_or_default();
        self.text.push_str(file);
        let mut ended = write!(self.text, ":{}", issued.line);
        for level in levels.iter().rev().skip(1) {
            ended = ended.and(write!(self.text, "<{}:{}", level.file, level.cursor.line));
        }
        let pass = levels.last().map_or(0, |l| l.pass);
        ended.and(write!(self.text, "#{pass} ")).unwrap_or_default();
    }

    pub(super) fn call(&mut self, call: &Call, number: Option<u32>) -> Result<(), String> {
        self.head(number);
        write!(self.text, "{call}").map_err(|e| e.to_string())?;
        self.end()
    }

    pub(super) fn text(&mut self, text: &str, number: Option<u32>) -> Result<(), String> {
        self.head(number);
        self.text.push_str(text);
        self.end()
    }

    fn head(&mut self, number: Option<u32>) {
        self.count += 1;
        // Most of the time goes into these lines: no formatting machinery.
        let mut digits = [b' '; 20];
        let mut left = self.count;
        let mut used = 0usize;
        for slot in digits.iter_mut().rev() {
            *slot = b'0' + u8::try_from(left % 10).unwrap_or(0);
            left /= 10;
            used += 1;
            if left == 0 {
                break;
            }
        }
        let shown = digits.get(20 - used.max(5)..).unwrap_or_default();
        self.text.push_str(core::str::from_utf8(shown).unwrap_or_default());
        match number {
            None => self.text.push_str(" N..... "),
            Some(n) => write!(self.text, " N{n:<6}").unwrap_or_default(),
        }
    }

    fn end(&mut self) -> Result<(), String> {
        self.text.push('\n');
        if self.text.len() >= 1 << 16 {
            return self.flush().map_err(|stop| match stop {
                Stop::Output(reason) => reason,
                Stop::Program(error) => error.to_string(),
            });
        }
        Ok(())
    }

    pub(super) fn flush(&mut self) -> Result<(), Stop> {
        let written = match &mut self.file {
            None => Stdio.out(&self.text).map_err(String::from),
            Some((path, file)) => {
                let done = file.write_all(self.text.as_bytes());
                done.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))
            }
        };
        self.text.clear();
        written.map_err(Stop::Output)
    }

    pub(super) fn finish(&mut self) -> Result<(), String> {
        self.flush().map_err(|stop| stop.to_string())?;
        match self.file.take() {
            None => Ok(()),
            Some((path, file)) => {
                let done = file.finish();
                done.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))
            }
        }
    }
}
