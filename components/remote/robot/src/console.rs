//! Dialogue of a person, or of a file, with a controller over lines of text: the terminal without its device.

use crate::{Framer, line::QUIET};
use std::collections::VecDeque;

/// Longest line in bytes, in both directions.
const MAX_TEXT: usize = 4096;
/// Largest number of lines of a file, and of lines that wait.
const MAX_LINES: usize = 1_000_000;
/// Lines that `:help` prints.
const HELP: &[&str] = &[
    ":send FILE   sends a file, one line for each answer or prompt; empty lines are left out",
    ":stop        ends the sending of a file",
    ":quit        ends the terminal",
    "a line that begins with a colon is sent with a second one before it: ::text",
];

/// Kind of an entry of the log.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LogKind {
    /// A line was sent.
    Sent,
    /// A line or a prompt was received.
    Received,
    /// Something failed.
    Error,
    /// Something else that a person should know.
    Note,
}

/// Entry of the log.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct LogEntry {
    /// Kind.
    pub kind: LogKind,
    /// Line of text without control characters.
    pub text: String,
}

/// Request of the person to the program.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum ConsoleRequest {
    /// The lines of this file, through [`Console::send_file`].
    Read(String),
    /// The end.
    Quit,
}

/// Settings of a dialogue.
#[derive(Clone, PartialEq, Debug)]
pub struct ConsoleOptions {
    /// Bytes behind each line that is sent.
    pub line_end: &'static str,
    /// Begin of a line or a prompt that is an answer; without any, all are.
    pub answers: Vec<String>,
    /// Text that the controller sends before the first line is sent to it.
    pub begin: Option<String>,
    /// Time for an answer, in seconds.
    pub timeout: f64,
    /// True if typed lines wait for the answer to the one before; false if they are sent at once.
    pub is_queued: bool,
}

/// File that is being sent.
#[derive(Debug)]
struct Sending {
    name: String,
    lines: VecDeque<String>,
    /// Number of lines that were sent.
    sent: usize,
}

/// Dialogue. Times are in seconds from any origin and never decrease.
#[derive(Debug)]
pub struct Console {
    options: ConsoleOptions,
    framer: Framer,
    last_byte: f64,
    queue: VecDeque<String>,
    sending: Option<Sending>,
    /// Line without an answer, and the time at which it was sent.
    awaited: Option<(String, f64)>,
    has_begun: bool,
    /// The begin has not come in its time.
    is_mute: bool,
    has_failed: bool,
    out: Vec<u8>,
    log: Vec<LogEntry>,
}

impl Console {
    /// Returns a dialogue before its first line.
    #[must_use]
    pub fn new(options: ConsoleOptions, now: f64) -> Self {
        let has_begun = options.begin.is_none();
        // The begin is awaited like an answer.
        let awaited = options.begin.as_ref().map(|text| (text.clone(), now));
        Self {
            options,
            framer: Framer::with_limit(MAX_TEXT),
            last_byte: now,
            queue: VecDeque::new(),
            sending: None,
            awaited,
            has_begun,
            is_mute: false,
            has_failed: false,
            out: Vec::new(),
            log: Vec::new(),
        }
    }

    /// Takes a typed line. Returns what only the program can do.
    pub fn enter(&mut self, line: &str, now: f64) -> Option<ConsoleRequest> {
        let is_own = line.starts_with(':') && !line.starts_with("::");
        if self.is_mute() && !is_own {
            self.fail(&format!("{line}: not sent, the controller has not begun"));
            return None;
        }
        if !self.options.is_queued && self.has_begun || self.is_mute() {
            return self.interpret(line, now);
        }
        if self.queue.len() < MAX_LINES {
            self.queue.push_back(line.to_owned());
        }
        self.turn(now)
    }

    /// Interprets the lines whose turn it is, up to one that only the program can do.
    pub fn turn(&mut self, now: f64) -> Option<ConsoleRequest> {
        while self.has_begun
            && self.sending.is_none()
            && (self.awaited.is_none() || !self.options.is_queued)
            && let Some(line) = self.queue.pop_front()
        {
            let request = self.interpret(&line, now);
            if request.is_some() {
                return request;
            }
        }
        None
    }

    fn interpret(&mut self, line: &str, now: f64) -> Option<ConsoleRequest> {
        let line = line.trim_end();
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            ":quit" => return Some(ConsoleRequest::Quit),
            ":help" => HELP.iter().for_each(|text| self.note(text)),
            ":stop" => self.stop(),
            ":send" if rest.trim().is_empty() => self.fail(":send needs the name of a file"),
            ":send" if self.sending.is_some() => self.fail("a file is being sent: :stop ends it"),
            ":send" => return Some(ConsoleRequest::Read(rest.trim().to_owned())),
            _ if line.starts_with("::") => self.text(line.get(1..).unwrap_or_default(), now),
            _ if word.starts_with(':') => self.fail(&format!("{word} has no meaning: :help")),
            _ => self.text(line, now),
        }
        None
    }

    fn text(&mut self, line: &str, now: f64) {
        if line.len() > MAX_TEXT {
            self.fail(&format!("the line has {} bytes, at most {MAX_TEXT} are sent", line.len()));
        } else if self.sending.is_some() {
            self.fail("a file is being sent: :stop ends it");
        } else {
            self.send(line.to_owned(), now);
        }
    }

    /// Sends the lines of a file, one for each answer.
    pub fn send_file(&mut self, name: &str, text: &str, now: f64) {
        let lines: VecDeque<String> = text
            .lines()
            .map(str::trim_end)
            .filter(|line| !line.is_empty())
            .map(str::to_owned)
            .collect();
        if lines.len() > MAX_LINES {
            return self.fail(&format!("{name} has more than {MAX_LINES} lines"));
        }
        if let Some(long) = lines.iter().position(|line| line.len() > MAX_TEXT) {
            return self.fail(&format!("{name}: line {} is too long", long + 1));
        }
        self.sending = Some(Sending { name: name.to_owned(), lines, sent: 0 });
        self.advance(now);
    }

    /// Ends the sending of a file.
    pub fn stop(&mut self) {
        match self.sending.take() {
            None => self.note("no file is being sent"),
            Some(Sending { name, sent, .. }) => {
                self.fail(&format!("{name}: stopped behind line {sent}"));
            }
        }
    }

    /// Takes bytes of the controller.
    pub fn receive(&mut self, bytes: &[u8], now: f64) {
        self.last_byte = now;
        let mut lines = Vec::new();
        self.framer.feed(bytes, |line| lines.push(line.map(visible)));
        for line in lines {
            self.line(line, now);
        }
    }

    /// Advances to a time: a text without an end is a prompt, and answers may be late.
    pub fn poll(&mut self, now: f64) {
        if self.framer.has_begun() && now >= self.last_byte + QUIET {
            let mut prompt = None;
            self.framer.quiet(|line| prompt = Some(line.map(visible)));
            if let Some(prompt) = prompt {
                self.line(prompt, now);
            }
        }
        if let Some((line, since)) = &self.awaited
            && now >= since + self.options.timeout
            && (self.is_paced() || !self.has_begun)
        {
            self.is_mute = !self.has_begun;
            let text = format!("no answer to {line} within {} s", self.options.timeout);
            self.abandon(&text);
        }
    }

    /// Returns when something happens next, if nothing is typed or received.
    #[must_use]
    pub fn next(&self) -> Option<f64> {
        let quiet = self.framer.has_begun().then_some(self.last_byte + QUIET);
        let is_paced = self.is_paced() || !self.has_begun;
        let late = self.awaited.as_ref().filter(|_| is_paced);
        let late = late.map(|(_, since)| since + self.options.timeout);
        [quiet, late].into_iter().flatten().reduce(f64::min)
    }

    /// Ends what waits for the controller, which has gone.
    pub fn closed(&mut self, why: &str) {
        if self.framer.has_begun() {
            let mut rest = None;
            self.framer.quiet(|line| rest = line.map(visible));
            if let Some(text) = rest {
                self.entry(LogKind::Received, text);
            }
        }
        if self.sending.is_some() || !self.queue.is_empty() {
            self.abandon(why);
        } else {
            self.note(why);
        }
        self.awaited = None;
    }

    /// Returns whether nothing waits: no line for its answer, and none for its turn.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.awaited.is_none() && self.queue.is_empty() && self.sending.is_none()
    }

    /// Returns whether the begin has not come in its time, nor since.
    #[must_use]
    pub const fn is_mute(&self) -> bool {
        self.is_mute && !self.has_begun
    }

    /// Returns whether anything has failed.
    #[must_use]
    pub const fn has_failed(&self) -> bool {
        self.has_failed
    }

    /// Returns the bytes to send.
    pub fn output(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.out)
    }

    /// Returns the new entries of the log.
    pub fn log(&mut self) -> Vec<LogEntry> {
        core::mem::take(&mut self.log)
    }

    /// Adds an error of the program's own, such as a file that cannot be read.
    pub fn fail(&mut self, text: &str) {
        self.has_failed = true;
        self.entry(LogKind::Error, text.to_owned());
    }

    /// Returns whether lines wait for answers.
    const fn is_paced(&self) -> bool {
        self.options.is_queued || self.sending.is_some()
    }

    fn note(&mut self, text: &str) {
        self.entry(LogKind::Note, text.to_owned());
    }

    fn entry(&mut self, kind: LogKind, text: String) {
        self.log.push(LogEntry { kind, text });
    }

    /// Gives up what was to be sent.
    fn abandon(&mut self, why: &str) {
        self.awaited = None;
        let text = match self.sending.take() {
            Some(Sending { name, sent, .. }) => format!("{name}: line {sent}: {why}"),
            None => why.to_owned(),
        };
        self.queue.clear();
        self.fail(&text);
    }

    fn line(&mut self, line: Option<String>, now: f64) {
        let Some(text) = line else {
            return self
                .fail(&format!("the controller has sent more than {MAX_TEXT} bytes in a line"));
        };
        self.entry(LogKind::Received, text.clone());
        if !self.has_begun {
            if self.options.begin.as_ref().is_some_and(|begin| text.contains(begin)) {
                (self.has_begun, self.awaited) = (true, None);
                self.advance(now);
            }
            return;
        }
        // A controller may send back what it was sent before it answers.
        let is_echo = self.awaited.as_ref().is_some_and(|(line, _)| line.trim() == text.trim());
        let answers = &self.options.answers;
        let is_refusal = text.trim_start().to_ascii_lowercase().starts_with("error");
        let is_answer =
            answers.is_empty() || answers.iter().any(|a| text.trim_start().starts_with(a));
        if self.awaited.is_none() || is_echo || !(is_answer || is_refusal) {
            return;
        }
        if is_refusal && self.sending.is_some() {
            return self.abandon(&format!("the controller has refused it: {text}"));
        }
        self.has_failed |= is_refusal && self.options.is_queued;
        self.awaited = None;
        self.advance(now);
    }

    /// Sends the next line of a file, unless an answer is awaited.
    fn advance(&mut self, now: f64) {
        if self.awaited.is_some() || !self.has_begun {
            return;
        }
        if let Some(sending) = &mut self.sending {
            if let Some(line) = sending.lines.pop_front() {
                sending.sent += 1;
                return self.send(line, now);
            }
            let text = format!("{}: {} lines sent", sending.name, sending.sent);
            self.sending = None;
            self.note(&text);
        }
    }

    fn send(&mut self, line: String, now: f64) {
        self.out.extend_from_slice(line.as_bytes());
        self.out.extend_from_slice(self.options.line_end.as_bytes());
        self.entry(LogKind::Sent, visible(line.as_bytes()));
        self.awaited = Some((line, now));
    }
}

/// Returns bytes as a text that moves no cursor.
fn visible(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    text.chars().map(|c| if c.is_control() && c != '\t' { '\u{fffd}' } else { c }).collect()
}
