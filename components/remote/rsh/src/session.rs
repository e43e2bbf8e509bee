//! A session: the state of one connection, and its lines.

use crate::{
    Machine, get, help,
    rows::{self, Needs},
    set,
};
use std::collections::VecDeque;

/// Number of texts of each kind that wait for `get error` and `get operator_display`.
const MAX_TEXTS: usize = 16;
/// Number of wrong passwords after which a connection ends.
const MAX_WRONG: u32 = 10;
/// Version of the protocol.
const VERSION: &str = "1.1";

/// Passwords and the name of the server.
#[derive(Clone, Debug)]
pub struct Passwords {
    /// Password of hello.
    pub connect: String,
    /// Password of `set enable`.
    pub enable: String,
    /// Name of the server.
    pub name: String,
}

/// Step after a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The next line.
    Line,
    /// The end of the connection.
    Close,
    /// The end of the machine.
    ShutDown,
}

/// Settings of a session, which its client sets and reads.
#[derive(Debug)]
pub(crate) struct Settings {
    pub(crate) echo: bool,
    pub(crate) verbose: bool,
    pub(crate) binary: bool,
    /// True if commands are waited for.
    pub(crate) waits: bool,
    /// Longest wait in seconds; 0 or less is as long as it takes.
    pub(crate) timeout: f64,
    /// True if each reading is a new one.
    pub(crate) fresh: bool,
    /// Units of length and angles that are shown.
    pub(crate) linear: &'static str,
    pub(crate) angular: &'static str,
    /// Refusals and errors of the machine that were not read yet.
    pub(crate) errors: VecDeque<String>,
    /// Messages of programs that were not read yet.
    pub(crate) messages: VecDeque<String>,
    /// Ticket of the last command.
    pub(crate) ticket: Option<u64>,
    /// Passwords that were wrong.
    pub(crate) wrong: u32,
}

impl Settings {
    pub(crate) fn fail(&mut self, why: &str) {
        push(&mut self.errors, why);
    }
}

fn push(texts: &mut VecDeque<String>, text: &str) {
    if texts.len() == MAX_TEXTS {
        texts.pop_front();
    }
    // A reply is one line.
    texts.push_back(text.replace(['\r', '\n'], " "));
}

/// Session of a connection.
#[derive(Debug)]
pub struct Session {
    settings: Settings,
    /// True after a successful hello.
    greeted: bool,
    /// Number of messages of the machine that were seen.
    seen: Option<u32>,
}

impl Default for Session {
    fn default() -> Self {
        let settings = Settings {
            echo: true,
            verbose: false,
            binary: false,
            waits: false,
            timeout: 0.0,
            fresh: true,
            linear: "AUTO",
            angular: "AUTO",
            errors: VecDeque::new(),
            messages: VecDeque::new(),
            ticket: None,
            wrong: 0,
        };
        Self { settings, greeted: false, seen: None }
    }
}

/// Returns whether a line stops the machine: what waits before it is of no use any more.
#[must_use]
pub fn is_stop(line: &str) -> bool {
    let mut words = line.split_ascii_whitespace();
    let is_set = words.next().is_some_and(|word| word.eq_ignore_ascii_case("set"));
    let name = words.next().unwrap_or_default();
    is_set && rows::stops(name, words.next().unwrap_or_default())
}

impl Session {
    /// Returns whether the client has said hello with the password.
    #[must_use]
    pub const fn is_greeted(&self) -> bool {
        self.greeted
    }

    /// Executes a line. Returns the reply, and what comes next.
    pub fn line(
        &mut self,
        line: &str,
        passwords: &Passwords,
        machine: &mut dyn Machine,
    ) -> (String, Next) {
        let mut out = String::new();
        if self.greeted && self.settings.echo {
            out.push_str(line);
            out.push_str("\r\n");
        }
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let Some((verb, args)) = words.split_first() else { return (out, Next::Line) };
        let mut next = Next::Line;
        match verb.to_ascii_uppercase().as_str() {
            "HELLO" => out.push_str(&self.hello(args, passwords)),
            "GET" => out.push_str(&self.get(args, machine)),
            "SET" => out.push_str(&self.set(line, args, passwords, machine)),
            "HELP" => out.push_str(&help::text(args.first().copied())),
            "QUIT" => next = Next::Close,
            "SHUTDOWN" if self.greeted && machine.has_control() => next = Next::ShutDown,
            "SHUTDOWN" => out.push_str("SHUTDOWN NAK\r\n"),
            _ => {}
        }
        if self.settings.wrong >= MAX_WRONG {
            next = Next::Close;
        }
        (out, next)
    }

    /// Refuses a line of `set` because a stop came after it, and returns the reply; `None` for other lines.
    #[must_use]
    pub fn left_out(&mut self, line: &str) -> Option<String> {
        let mut words = line.split_ascii_whitespace();
        words.next().filter(|word| word.eq_ignore_ascii_case("set"))?;
        let name = words.next()?.to_ascii_uppercase();
        self.settings.fail("a stop has come after it");
        let echo = if self.settings.echo { format!("{line}\r\n") } else { String::new() };
        Some(format!("{echo}SET {name} NAK\n\r"))
    }

    fn hello(&mut self, args: &[&str], passwords: &Passwords) -> String {
        if let [password, _, _, ..] = args {
            if *password == passwords.connect {
                self.greeted = true;
                return format!("HELLO ACK {} {VERSION}\r\n", passwords.name);
            }
            self.settings.wrong += 1;
        }
        "HELLO NAK\r\n".to_owned()
    }

    fn get(&mut self, args: &[&str], machine: &mut dyn Machine) -> String {
        let Some((name, args)) = args.split_first() else { return "GET NAK\r\n".to_owned() };
        if self.settings.fresh {
            self.poll(machine);
        }
        let mut look = get::Look { settings: &mut self.settings, machine };
        let reply = rows::find(name).and_then(|row| row.get).and_then(|get| get(&mut look, args));
        match reply {
            Some(text) => format!("{text}\r\n"),
            None => format!("GET {} NAK\r\n\r\n", name.to_ascii_uppercase()),
        }
    }

    /// Reads the machine's state and its messages.
    fn poll(&mut self, machine: &mut dyn Machine) {
        machine.poll();
        let task = &machine.state().task;
        let count = task.count("messages", 0);
        // The machine shows its last message alone.
        if self.seen.is_some_and(|seen| seen != count) {
            let text = task.text("message");
            if task.count("message_level", 0) == 0 {
                push(&mut self.settings.messages, &text);
            } else if self.settings.errors.back().is_none_or(|last| *last != text) {
                push(&mut self.settings.errors, &text);
            }
        }
        self.seen = Some(count);
    }

    fn set(
        &mut self,
        line: &str,
        args: &[&str],
        passwords: &Passwords,
        machine: &mut dyn Machine,
    ) -> String {
        if !self.greeted {
            return "SET NAK\r\n".to_owned();
        }
        let Some((name, args)) = args.split_first() else { return "SET NAK\n\r".to_owned() };
        self.poll(machine);
        let row = rows::find(name).and_then(|row| row.set);
        let done = row.is_some_and(|(needs, set)| {
            let free = needs == Needs::Hello || rows::stops(name, args.first().unwrap_or(&""));
            let permitted = free || machine.has_control();
            if !permitted {
                self.settings.fail("this connection has no control: set enable PASSWORD");
            }
            let mut order = set::SetLine {
                settings: &mut self.settings,
                machine: &mut *machine,
                rest: rest(line),
                password: &passwords.enable,
            };
            permitted && set(&mut order, args)
        });
        match (done, self.settings.verbose) {
            (true, true) => format!("SET {} ACK\n\r", name.to_ascii_uppercase()),
            (true, false) => String::new(),
            (false, _) => format!("SET {} NAK\n\r", name.to_ascii_uppercase()),
        }
    }
}

/// Returns the text of a line after its second word.
fn rest(line: &str) -> &str {
    let mut text = line.trim_start();
    for _ in 0..2 {
        text = text.find(|c: char| c.is_ascii_whitespace()).map_or("", |at| &text[at..]);
        text = text.trim_start();
    }
    text.trim_end()
}
