//! A session: a connection, its user, and its program.

use crate::{
    answer::{Answer, Reason},
    line::{Lines, TextLine},
    words::{Code, Word},
};
use std::{collections::VecDeque, net::IpAddr};

/// Largest program in bytes.
pub const MAX_PROGRAM: usize = 16 << 20;

/// A connection.
#[derive(Debug)]
pub(crate) struct Session {
    /// Address of the client's computer.
    pub(crate) peer: IpAddr,
    pub(crate) lines: Lines,
    /// Lines that arrived while a start was checked, with the number of their bytes.
    held: VecDeque<HeldLine>,
    pub(crate) held_bytes: usize,
    /// True if these lines end inside a program.
    in_program: bool,
    pub(crate) output: Vec<u8>,
    /// Name of the user after the login.
    pub(crate) user: Option<String>,
    /// True if the user may send and run programs.
    pub(crate) works: bool,
    /// Lines of the program, each with LF.
    pub(crate) program: Vec<u8>,
    /// Program text on its way.
    pub(crate) payload: Option<Payload>,
    /// The answer that the next request waits for.
    pub(crate) wait: Option<Wait>,
    /// Refusals in a row before the login.
    pub(crate) refusals: u32,
    /// True once the connection closes after its output.
    pub(crate) closes: bool,
    /// Time of the connection, and of the last line, in milliseconds.
    pub(crate) since: u64,
    pub(crate) heard: u64,
}

/// An answer that comes later; until then, no further request is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Wait {
    /// Result of the login of this user.
    SignIn(String),
    /// Result of the start.
    Start,
    /// End of the cancelled job.
    Cancel,
}

/// A line that arrived while a start was checked.
#[derive(Debug)]
struct HeldLine {
    line: TextLine,
    /// True for the request CANCELAR.
    cancels: bool,
}

/// Lines of a program on their way, up to a line with a dot.
#[derive(Debug)]
pub(crate) struct Payload {
    word: Word,
    text: Vec<u8>,
    lines: u32,
    /// Answer to lines that are only read away.
    refusal: Option<Answer>,
}

impl Session {
    pub(crate) fn new(peer: IpAddr, now: u64) -> Self {
        Self {
            peer,
            lines: Lines::default(),
            held: VecDeque::new(),
            held_bytes: 0,
            in_program: false,
            output: Vec::new(),
            user: None,
            works: false,
            program: Vec::new(),
            payload: None,
            wait: None,
            refusals: 0,
            closes: false,
            since: now,
            heard: now,
        }
    }

    /// Returns the next line that is to be executed.
    pub(crate) fn next_line(&mut self) -> Option<TextLine> {
        let Some(HeldLine { line, .. }) = self.held.pop_front() else {
            self.in_program = false;
            return self.lines.next();
        };
        self.held_bytes = self.held_bytes.saturating_sub(size(&line));
        Some(line)
    }

    /// Keeps the lines that have arrived for later; returns true if a request among those kept is CANCELAR.
    pub(crate) fn hold(&mut self) -> bool {
        while let Some(line) = self.lines.next() {
            let cancels = matches!(&line, TextLine::Text(text) if self.is_cancel(text));
            self.held_bytes += size(&line);
            self.held.push_back(HeldLine { line, cancels });
        }
        self.held.iter().any(|held| held.cancels)
    }

    /// Follows the lines that are kept; returns whether this one is the request CANCELAR.
    fn is_cancel(&mut self, line: &str) -> bool {
        if self.in_program {
            self.in_program = line != ".";
            return false;
        }
        let line = line.trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let word = Word::parse(word);
        let alone = rest.trim_start().is_empty();
        self.in_program = matches!(word, Some(Word::EnviarNuevo | Word::EnviarAgregar)) && alone;
        word == Some(Word::Cancelar) && alone
    }

    pub(crate) fn say(&mut self, answer: &Answer) {
        self.output.extend_from_slice(answer.line().as_bytes());
    }

    /// Begins to read a program; with a refusal it is only read away. `line` is the program if it is not empty.
    pub(crate) fn begin(&mut self, word: Word, line: &str, refusal: Option<Answer>) {
        let mut payload = Payload { word, text: Vec::new(), lines: 0, refusal };
        if line.is_empty() {
            self.payload = Some(payload);
        } else {
            payload.add(line, self.room(word));
            self.store(payload);
        }
    }

    /// Reads a line of a program.
    pub(crate) fn read(&mut self, mut payload: Payload, line: &TextLine) {
        let room = self.room(payload.word);
        payload.lines = payload.lines.saturating_add(1);
        match line {
            TextLine::Text(text) if text == "." => return self.store(payload),
            // A line that begins with a dot has another one before it.
            TextLine::Text(text) => payload.add(text.strip_prefix('.').unwrap_or(text), room),
            TextLine::Long => {
                let text = format!("line {} has more than 1024 bytes", payload.lines);
                payload.refuse(Code::Largo, text);
            }
            TextLine::NoText => {
                payload.refuse(Code::Sintaxis, format!("{} the line is no UTF-8", payload.lines));
            }
        }
        self.payload = Some(payload);
    }

    fn room(&self, word: Word) -> usize {
        let kept = if word == Word::EnviarAgregar { self.program.len() } else { 0 };
        MAX_PROGRAM.saturating_sub(kept)
    }

    /// Ends a program: it is stored as a whole, or refused and the one before stays.
    fn store(&mut self, payload: Payload) {
        let Payload { word, mut text, refusal, .. } = payload;
        if let Some(refusal) = refusal {
            return self.say(&refusal);
        }
        if word == Word::EnviarNuevo {
            self.program = text;
        } else {
            self.program.append(&mut text);
        }
        self.say(&Answer::Recibido);
    }
}

impl Payload {
    fn add(&mut self, line: &str, room: usize) {
        if self.refusal.is_some() {
            return;
        }
        if self.text.len() + line.len() + 1 > room {
            let text = format!("the program has more than {} MiB", MAX_PROGRAM >> 20);
            return self.refuse(Code::Largo, text);
        }
        self.text.extend_from_slice(line.as_bytes());
        self.text.push(b'\n');
    }

    /// Notes the first reason for which the program is not stored.
    fn refuse(&mut self, code: Code, text: String) {
        self.text = Vec::new();
        let (word, why) = (self.word, Reason::new(code, text));
        self.refusal.get_or_insert_with(|| refusal(word, why));
    }
}

/// Returns the number of bytes that a line takes while it is kept.
const fn size(line: &TextLine) -> usize {
    let text = if let TextLine::Text(text) = line { text.len() } else { 0 };
    text + size_of::<HeldLine>()
}

/// Returns the refusal of a program that is sent.
pub(crate) fn refusal(word: Word, why: Reason) -> Answer {
    if word == Word::EnviarAgregar { Answer::ErrorAgregar(why) } else { Answer::ErrorNuevo(why) }
}
