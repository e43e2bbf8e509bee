//! The interactive prompt. The editor has a thread of its own, while the session's thread keeps
//! serving the engine. The two exchange data only through channels.

mod aside;
mod editor;

use crate::{
    Bytes, Lines, Outcome, Physical, Session, Stdin,
    manual::complete::{self, Completion},
    terminal::termination::{Held, interrupt},
};
use hal_protocol::{Link, Request};
use rustix::termios::{OptionalActions, Termios, tcgetattr, tcsetattr};
use std::{
    sync::mpsc::{self, Receiver, Sender, TryRecvError},
    thread,
    time::Duration,
};

pub(crate) use aside::{Aside, Kept, was_said};

/// Time for which the session's thread serves the engine before it checks for input again.
const SERVE_MS: u32 = 10;

/// An order to the editor.
enum Order {
    /// Read a line. With `continuing` it continues the line before.
    Read { continuing: bool },
}

/// A message from the editor.
enum Event {
    /// The editor has taken over the terminal.
    Begun,
    /// The user typed a line, or pasted several.
    Line(String),
    /// Request for completions at the end of this line.
    Complete(String),
    /// The user cancelled the line. `empty` is true if nothing had been typed.
    Interrupted { empty: bool },
    /// End of input.
    End,
}

/// Executes lines from the keyboard or from standard input. With `flow` the virtual clock moves
/// meanwhile.
pub(crate) fn typed(session: &mut Session<'_>, flow: bool) -> Outcome {
    let script = session.style_mut().script;
    let person = !script && hal_output::is_person();
    let local = session.link.is_local();
    match person.then(|| Prompt::new(flow, local)).flatten() {
        Some(prompt) => session.file("<stdin>", prompt),
        None => session.file("<stdin>", Stdin::new(script, flow)),
    }
}

/// Lines that a person types.
struct Prompt {
    flow: bool,
    /// Typed text that has not been read yet.
    typed: Bytes,
    orders: Sender<Order>,
    events: Receiver<Event>,
    answers: Sender<Completion>,
    /// True if the editor has had the terminal since the last order.
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

    /// Returns a line with its continuations, or `None` at the end of input.
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

    /// Answers the editor's requests until it has a line, and serves the engine meanwhile.
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
            // Otherwise the editor would take over the terminal after it has been restored.
            drop(self.events.recv_timeout(Duration::from_secs(1)));
        }
    }
}

/// Result of an attempt to read a line.
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

/// The state of the terminal before editing. Drop restores it, even in the middle of a line.
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
            // Ends bracketed paste mode and starts a new line for further output. The terminal may
            // be gone.
            hal_output::print("\x1b[?2004l\r\n").unwrap_or_default();
            tcsetattr(std::io::stdin(), OptionalActions::Now, &self.before).unwrap_or_default();
            drop(held);
        }
    }
}
