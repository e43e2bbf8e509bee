//! The interactive prompt. A person edits lines on a thread of its own, and the session's thread
//! goes on serving the engine: neither ever waits for the other but through a channel.

mod aside;
mod editor;
mod history;

use crate::{
    Bytes, Lines, Outcome, Physical, Session, Stdin, colour,
    complete::{self, Completion},
    signals::{Held, interrupt},
};
use hal_protocol::{Link, Request};
use rustix::termios::{OptionalActions, Termios, tcgetattr, tcsetattr};
use std::{
    sync::mpsc::{self, Receiver, Sender, TryRecvError},
    thread,
    time::Duration,
};

pub(crate) use aside::{Aside, Kept};

/// How long the session's thread serves the engine before it looks at the keyboard again.
const SERVE_MS: u32 = 10;

/// What the editor is told.
enum Order {
    /// Read a line; the last word of `before` may be continued in it.
    Read { continuing: bool },
}

/// What the editor says.
enum Event {
    /// The terminal is the editor's from here on.
    Begun,
    /// A line was typed, or several were pasted.
    Line(String),
    /// What may stand at the end of this line?
    Complete(String),
    /// The line is given up. `empty`: there was none.
    Interrupted { empty: bool },
    /// Nothing more will come.
    End,
}

/// Carries out what is typed or comes by standard input. `flow`: the virtual clock moves
/// meanwhile.
pub(crate) fn typed(session: &mut Session<'_>, flow: bool) -> Outcome {
    let script = session.style_mut().script;
    let person = !script && colour::is_person();
    let local = session.link.is_local();
    match person.then(|| Prompt::new(flow, local)).flatten() {
        Some(prompt) => session.file("<stdin>", prompt),
        None => session.file("<stdin>", Stdin::new(script, flow)),
    }
}

/// Lines that a person types.
struct Prompt {
    flow: bool,
    /// What was typed and not taken yet.
    typed: Bytes,
    orders: Sender<Order>,
    events: Receiver<Event>,
    answers: Sender<Completion>,
    /// Whether the editor has the terminal since the last order.
    begun: bool,
    terminal: Restored,
}

impl Prompt {
    fn new(flow: bool, local: bool) -> Option<Self> {
        let terminal = Restored::new()?;
        let (orders, to_do) = mpsc::channel();
        let (say, events) = mpsc::channel();
        let (answers, answered) = mpsc::channel();
        let run = move || editor::run(&to_do, &say, answered, local);
        thread::Builder::new().name("prompt".to_owned()).spawn(run).ok()?;
        Some(Self { flow, typed: Bytes::default(), orders, events, answers, begun: true, terminal })
    }

    /// A line with those that continue it; none when there is nothing more.
    fn read(&mut self, link: &mut dyn Link) -> Option<Vec<u8>> {
        let mut text = String::new();
        loop {
            if link.is_ending() {
                return None;
            }
            self.begin(!text.is_empty())?;
            match self.until_line(&text, link)? {
                Typed::Line(line) => {
                    text.push_str(&line);
                    text.push('\n');
                    if !line.ends_with('\\') {
                        return Some(text.into_bytes());
                    }
                }
                Typed::GivenUp => text.clear(),
            }
        }
    }

    fn begin(&mut self, continuing: bool) -> Option<()> {
        self.terminal.edited = Some(Held::new());
        aside::hold(true);
        self.begun = false;
        self.orders.send(Order::Read { continuing }).ok()
    }

    fn end(&mut self) {
        aside::hold(false);
        self.terminal.edited = None;
    }

    /// Answers what the editor asks until it has a line. The engine is served meanwhile.
    fn until_line(&mut self, before: &str, link: &mut dyn Link) -> Option<Typed> {
        loop {
            match self.event(link)? {
                Event::Begun => self.begun = true,
                Event::Line(line) => {
                    self.end();
                    return Some(Typed::Line(line));
                }
                Event::Complete(line) => {
                    let joined = before.replace("\\\n", "");
                    let mut found = complete::complete(&format!("{joined}{line}"), link);
                    found.at = found.at.saturating_sub(joined.len());
                    self.answers.send(found).ok()?;
                }
                Event::Interrupted { empty } => {
                    self.end();
                    if empty && before.is_empty() {
                        interrupt();
                        return None;
                    }
                    return Some(Typed::GivenUp);
                }
                Event::End => {
                    self.end();
                    return None;
                }
            }
        }
    }

    fn event(&self, link: &mut dyn Link) -> Option<Event> {
        loop {
            match self.events.try_recv() {
                Ok(event) => return Some(event),
                Err(TryRecvError::Disconnected) => return None,
                Err(TryRecvError::Empty) => {}
            }
            if self.terminal.edited.as_ref().is_some_and(Held::has_come) {
                return None;
            }
            if link.is_local() {
                let idle = Request::Idle { ms: SERVE_MS, flow: self.flow };
                if link.is_ending() || link.call(idle).is_err() {
                    return None;
                }
            } else if let Ok(event) = self.events.recv_timeout(Duration::from_millis(100)) {
                return Some(event);
            }
        }
    }
}

impl Drop for Prompt {
    fn drop(&mut self) {
        if !self.begun && self.terminal.edited.is_some() {
            // It would take the terminal after that was put right.
            drop(self.events.recv_timeout(Duration::from_secs(1)));
        }
    }
}

/// How an attempt to read a line ended.
enum Typed {
    Line(String),
    GivenUp,
}

impl Lines for Prompt {
    fn next(&mut self, continuing: bool, link: &mut dyn Link) -> Option<Physical> {
        if let Some(line) = self.typed.next(continuing, link) {
            return Some(line);
        }
        let text = self.read(link)?;
        self.typed = Bytes::new(text);
        self.typed.next(continuing, link)
    }
}

/// The terminal as it was found; put right again even if the editor is left in the middle of a
/// line.
struct Restored {
    before: Termios,
    /// Set while the editor has the terminal.
    edited: Option<Held>,
}

impl Restored {
    fn new() -> Option<Self> {
        Some(Self { before: tcgetattr(std::io::stdin()).ok()?, edited: None })
    }
}

impl Drop for Restored {
    fn drop(&mut self) {
        aside::hold(false);
        if let Some(held) = self.edited.take() {
            // Pasting as usual, and a line of its own for whoever writes next. The terminal may have gone.
            hal_output::print("\x1b[?2004l\r\n").unwrap_or_default();
            tcsetattr(std::io::stdin(), OptionalActions::Now, &self.before).unwrap_or_default();
            drop(held);
        }
    }
}
