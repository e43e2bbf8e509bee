//! The client: what it sends next, and what the answers mean.

use crate::{
    answer::{Answer, Reason},
    line::{Line, Lines},
    words::Word,
};

/// Time between two questions for the progress, in milliseconds.
const ASK_MS: u64 = 1000;

/// A step of the client's work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// The login has been sent.
    SignsIn,
    /// The program has been sent.
    Sends,
    /// The start has been sent; its job runs, or is refused.
    Runs,
    /// The cancellation has been sent.
    Cancels,
    /// Only the progress has been asked for.
    Asks,
    /// The farewell has been sent.
    Leaves,
}

/// Something that people want to know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// The login succeeded.
    SignedIn,
    /// The server has the program.
    Sent,
    /// Progress in percent; told as it changes.
    Progress(u8),
}

/// Result of the client's work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// Everything was done.
    Done,
    /// The job was cancelled from here.
    Cancelled,
    /// The login was refused.
    Denied(Reason),
    /// The program was not stored, or not run.
    Refused(Reason),
    /// The server stops.
    Stopped,
    /// The connection has ended before an answer.
    Lost,
    /// The server has sent this line, which is no answer to what it was asked.
    Strange(String),
}

/// The client: it logs in, sends a program, runs it and leaves; without a program it asks for the progress.
#[derive(Debug)]
pub struct Client {
    lines: Lines,
    output: Vec<u8>,
    events: Vec<Event>,
    program: Option<Vec<u8>>,
    step: Step,
    progress: Option<u8>,
    /// Time of the last question for the progress.
    asked: u64,
    end: Option<End>,
}

impl Client {
    /// Begins with the login. `program` is sent and run.
    pub fn new(user: &str, secret: &str, program: Option<Vec<u8>>) -> Self {
        Self {
            lines: Lines::default(),
            output: format!("{} {user}:{secret}\r\n", Word::Ingresar.text()).into_bytes(),
            events: Vec::new(),
            program,
            step: Step::SignsIn,
            progress: None,
            asked: 0,
            end: None,
        }
    }

    /// Returns the bytes for the server.
    pub fn output(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.output)
    }

    /// Returns what has happened since the last call.
    pub fn events(&mut self) -> Vec<Event> {
        core::mem::take(&mut self.events)
    }

    /// Returns the result, once the server has closed the connection or nothing more is to be awaited.
    pub fn end(&self) -> Option<&End> {
        self.end.as_ref().filter(|_| self.step == Step::Leaves)
    }

    /// Takes bytes of the server.
    pub fn receive(&mut self, bytes: &[u8], now: u64) {
        self.lines.push(bytes);
        while let Some(line) = self.lines.next() {
            let answer = match &line {
                Line::Text(text) => Answer::parse(text).ok_or_else(|| text.clone()),
                Line::Long => Err("a line of more than 1024 bytes".to_owned()),
                Line::NoText => Err("a line that is no UTF-8".to_owned()),
            };
            match answer {
                Ok(answer) => self.answer(answer, now),
                Err(text) => self.finish(End::Strange(text)),
            }
        }
    }

    /// Takes the end of the connection.
    pub fn closed(&mut self) {
        self.finish(End::Lost);
        self.step = Step::Leaves;
    }

    /// Asks for the progress while a job runs, which also shows that this client is there.
    pub fn poll(&mut self, now: u64) {
        if self.step == Step::Runs && now >= self.asked + ASK_MS {
            self.asked = now;
            self.say(Word::Avance);
        }
    }

    /// Cancels the job, or leaves if none runs.
    pub fn cancel(&mut self) {
        match self.step {
            Step::Runs => {
                self.step = Step::Cancels;
                self.say(Word::Cancelar);
            }
            Step::Cancels | Step::Leaves => {}
            Step::SignsIn | Step::Sends | Step::Asks => self.finish(End::Cancelled),
        }
    }

    fn say(&mut self, word: Word) {
        self.output.extend_from_slice(format!("{}\r\n", word.text()).as_bytes());
    }

    /// Notes the result, if there is none yet, and leaves.
    fn finish(&mut self, end: End) {
        self.end.get_or_insert(end);
        if self.step != Step::Leaves {
            self.step = Step::Leaves;
            self.say(Word::Salir);
        }
    }

    fn answer(&mut self, answer: Answer, now: u64) {
        match (self.step, answer) {
            (Step::SignsIn, Answer::Aceptado) => {
                self.events.push(Event::SignedIn);
                match self.program.take() {
                    Some(program) => self.send(&program),
                    None => {
                        self.step = Step::Asks;
                        self.say(Word::Avance);
                    }
                }
            }
            (Step::Sends, Answer::Recibido) => {
                self.events.push(Event::Sent);
                (self.step, self.asked) = (Step::Runs, now);
                self.say(Word::Ejecutar);
            }
            (Step::Runs | Step::Asks | Step::Cancels, Answer::Avance(percent)) => {
                if self.progress.replace(percent) != Some(percent) {
                    self.events.push(Event::Progress(percent));
                }
                if self.step == Step::Asks {
                    self.finish(End::Done);
                }
            }
            // The job may end before the server has read that it is cancelled.
            (Step::Runs | Step::Cancels, Answer::Terminado) => {
                if self.progress.replace(100) != Some(100) {
                    self.events.push(Event::Progress(100));
                }
                self.finish(End::Done);
            }
            (Step::Cancels, Answer::Cancelado) => self.finish(End::Cancelled),
            (_, Answer::Denegado(why)) => self.finish(End::Denied(why)),
            (
                Step::SignsIn | Step::Asks | Step::Sends | Step::Runs | Step::Cancels,
                Answer::Error(why),
            )
            | (
                Step::Sends | Step::Runs | Step::Cancels,
                Answer::ErrorNuevo(why) | Answer::ErrorEjecutar(why),
            ) => self.finish(End::Refused(why)),
            (_, Answer::Desconexion) => self.finish(End::Stopped),
            // Answers to what was asked before the farewell.
            (Step::Leaves, _) => {}
            (_, strange) => self.finish(End::Strange(strange.to_string())),
        }
    }

    fn send(&mut self, program: &[u8]) {
        self.step = Step::Sends;
        self.say(Word::EnviarNuevo);
        for line in program.split(|byte| *byte == b'\n') {
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            if line.starts_with(b".") {
                self.output.push(b'.');
            }
            self.output.extend_from_slice(line);
            self.output.extend_from_slice(b"\r\n");
        }
        self.output.extend_from_slice(b".\r\n");
    }
}
