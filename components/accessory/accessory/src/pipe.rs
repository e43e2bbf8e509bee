//! The pipe whose lines press keys: any number of programs write to it.

use hal_component::{Builder, Error, Messages, Out, Touch, Work};
use hal_handheld::{BadLine, LineReader, Press, keys::STOP, line::parse};
use rustix::fs::{CWD, FileType, Mode, OFlags, fstat, mkfifoat, open};
use std::{
    collections::VecDeque,
    fs::File,
    io::{ErrorKind, Read as _},
    sync::{Arc, Mutex, PoisonError},
};

use crate::presses::Presses;

/// Period of the worker, in nanoseconds.
const PERIOD_NS: i64 = 5_000_000;
/// Largest number of presses that are read while there is no room for them, to find STOP among them.
const AHEAD: usize = 16_384;
/// Number of bytes of a line without its end that count as an item of work.
const PIECE: usize = 4096;
/// Number of bytes that a pipe holds.
const PIPE_BYTES: usize = 65_536;

/// Opens a pipe, or makes it.
///
/// # Errors
/// The path is something else than a pipe, or it cannot be made or opened.
pub(crate) fn open_pipe(path: &str) -> Result<File, Error> {
    let fail =
        |e: rustix::io::Errno| Error::new(format!("pipe {path}: {}", std::io::Error::from(e)));
    match mkfifoat(CWD, path, Mode::RUSR | Mode::WUSR) {
        Ok(()) | Err(rustix::io::Errno::EXIST) => {}
        Err(e) => return Err(fail(e)),
    }
    // This end is open for both, so that the pipe does not end when its last writer closes it.
    let flags = OFlags::RDWR | OFlags::NONBLOCK | OFlags::CLOEXEC | OFlags::NOFOLLOW;
    let pipe = open(path, flags, Mode::empty()).map_err(fail)?;
    let kind = FileType::from_raw_mode(fstat(&pipe).map_err(fail)?.st_mode);
    if kind != FileType::Fifo {
        return Err(Error::new(format!("pipe {path}: it is no named pipe: mkfifo makes one")));
    }
    Ok(File::from(pipe))
}

/// Settings of the lines.
#[derive(Clone, Copy)]
pub(crate) struct Lines {
    /// Number of keys.
    pub(crate) keys: u8,
    /// Time between two frames in milliseconds.
    pub(crate) period_ms: f64,
}

/// Declares the worker of a pipe. The pipe is opened with the machine, never while hardware is simulated.
///
/// # Errors
/// A name is taken.
pub(crate) fn declare(
    b: &mut Builder<'_>,
    path: String,
    lines: Lines,
    queue: Presses,
) -> Result<(), Error> {
    let doc = "Number of lines of the pipe that pressed nothing.";
    let bad_lines = b.item("keypad.bad-lines", doc, 0)?;
    if path.is_empty() || b.is_simulated() {
        return Ok(());
    }
    let opened = Arc::new(Mutex::new(None));
    let slot = opened.clone();
    b.on_open(move |_| {
        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(open_pipe(&path)?);
        Ok(())
    })?;
    let worker = PipeReader {
        opened,
        pipe: None,
        lines,
        reader: LineReader::default(),
        read: Vec::new(),
        ahead: VecDeque::new(),
        stop: 0,
        queue,
        bad_lines,
        messages: b.messages(),
    };
    b.worker("keypad.pipe", "Reads lines of the pipe.", PERIOD_NS, 64, worker)
}

/// Worker that reads the pipe.
#[derive(Touch)]
struct PipeReader {
    #[state]
    opened: Arc<Mutex<Option<File>>>,
    #[state]
    pipe: Option<File>,
    #[state]
    lines: Lines,
    #[state]
    reader: LineReader,
    /// Bytes that have been read, and whose lines have not.
    #[state]
    read: Vec<u8>,
    /// Presses that have been read, and for which there was no room yet.
    #[state]
    ahead: VecDeque<Press>,
    /// Number of the last press of STOP whose forgotten lines are gone.
    #[state]
    stop: u64,
    #[state]
    queue: Presses,
    bad_lines: Out<u32>,
    messages: Messages,
}

impl Work for PipeReader {
    fn work(&mut self, items: u32) -> u32 {
        if let Some(pipe) = self.opened.lock().unwrap_or_else(PoisonError::into_inner).take() {
            self.pipe = Some(pipe);
        }
        let mut done = 0;
        self.send();
        while done < items && self.ahead.len() < AHEAD && self.one_line() {
            self.send();
            done += 1;
        }
        done
    }
}

impl PipeReader {
    /// Sends presses for which there is room, unless another sender has pressed STOP after them.
    fn send(&mut self) {
        let mut queue = self.queue.lock();
        if queue.stop() != self.stop {
            self.stop = queue.stop();
            drop(queue);
            return self.forget();
        }
        while let Some(press) = self.ahead.front().copied()
            && queue.room(&[press]) > 0
        {
            queue.send(&[press], None);
            self.ahead.pop_front();
        }
        self.stop = queue.stop();
    }

    /// Forgets what is in the pipe. A line whose end is not there yet is a later one.
    fn forget(&mut self) {
        self.ahead.clear();
        for byte in self.read.drain(..) {
            let _: Option<_> = self.reader.feed(byte);
        }
        let mut buffer = [0; PIECE];
        for _ in 0..PIPE_BYTES / PIECE {
            let Some(Ok(read)) = self.pipe.as_mut().map(|pipe| pipe.read(&mut buffer)) else {
                return;
            };
            for byte in buffer.iter().take(read) {
                let _: Option<_> = self.reader.feed(*byte);
            }
        }
    }

    /// Reads one line, or a piece of an endless one; returns false if there is none.
    fn one_line(&mut self) -> bool {
        let mut bytes = 0;
        while bytes < PIECE {
            let mut used = 0;
            let mut line = None;
            for byte in &self.read {
                used += 1;
                line = self.reader.feed(*byte);
                if line.is_some() {
                    break;
                }
            }
            self.read.drain(..used);
            if let Some(line) = line {
                self.take(line);
                return true;
            }
            let mut buffer = [0; 256];
            match self.pipe.as_mut().map(|pipe| pipe.read(&mut buffer)) {
                Some(Ok(read)) if read > 0 => {
                    self.read.extend_from_slice(buffer.get(..read).unwrap_or_default());
                    bytes += read;
                }
                Some(Err(e)) if e.kind() != ErrorKind::WouldBlock => {
                    self.messages
                        .error("the pipe has failed: its lines press nothing any more", &[]);
                    self.pipe = None;
                    return false;
                }
                _ => return false,
            }
        }
        true
    }

    fn take(&mut self, line: Result<usize, BadLine>) {
        let press = line
            .and_then(|len| parse(self.reader.line(len), self.lines.keys, self.lines.period_ms));
        match press {
            Ok(press) => {
                if press.key == STOP {
                    self.ahead.clear();
                }
                self.ahead.push_back(press);
                self.send();
            }
            Err(bad) => {
                self.bad_lines.set(self.bad_lines.get().wrapping_add(1));
                self.messages.warn(message(bad), &[f64::from(self.lines.keys)]);
            }
        }
    }
}

/// Returns the message about a line.
const fn message(bad: BadLine) -> &'static str {
    match bad {
        BadLine::Empty => "an empty line of the pipe presses nothing: a line is N, or N MS",
        BadLine::Long => "a line of the pipe of more than 32 bytes presses nothing",
        BadLine::Encoding => "a line of the pipe that is not ASCII text presses nothing",
        BadLine::Number => "a line of the pipe with a word that is no whole number presses nothing",
        BadLine::Key(_) => "a line of the pipe names no key: keys are 1 to {}",
        BadLine::Time => "a line of the pipe has a time that is not 1 to 10000 ms",
        BadLine::Words => "a line of the pipe with more than two words presses nothing",
    }
}
