//! A session: a connection, its user, and its program.

use crate::{
    answer::{Answer, Reason},
    line::{Line, Lines},
    words::{Code, Word},
};

/// Largest program in bytes.
pub const MAX_PROGRAM: usize = 16 << 20;

/// A connection.
#[derive(Debug)]
pub(crate) struct Session {
    pub(crate) lines: Lines,
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
    pub(crate) fn new(now: u64) -> Self {
        Self {
            lines: Lines::default(),
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
    pub(crate) fn read(&mut self, mut payload: Payload, line: &Line) {
        let room = self.room(payload.word);
        payload.lines = payload.lines.saturating_add(1);
        match line {
            Line::Text(text) if text == "." => return self.store(payload),
            // A line that begins with a dot has another one before it.
            Line::Text(text) => payload.add(text.strip_prefix('.').unwrap_or(text), room),
            Line::Long => {
                let text = format!("line {} has more than 1024 bytes", payload.lines);
                payload.refuse(Code::Largo, text);
            }
            Line::NoText => {
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

/// Returns the refusal of a program that is sent.
pub(crate) fn refusal(word: Word, why: Reason) -> Answer {
    if word == Word::EnviarAgregar { Answer::ErrorAgregar(why) } else { Answer::ErrorNuevo(why) }
}
