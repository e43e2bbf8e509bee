//! `--run`: a program on the machine, from e-stop to the end of the program.

use crate::{Error, Outcome, Session};
use hal_protocol::{Reply, Request, TicketInfo};
use std::path::Path;

/// Machine time between two looks at the program, in nanoseconds.
const LOOK_NS: u64 = 100_000_000;

/// Empties the line of a terminal.
const CLEAR: &str = "\r\x1b[K";

/// The commands that bring a machine from e-stop to the begin of a program.
const BEFORE: [(&str, &[&str]); 4] = [
    ("task.estop-reset", &[]),
    ("task.on", &[]),
    ("task.home", &["joint=all"]),
    ("task.mode", &["mode=auto"]),
];

/// Runs a program and tells how it ended, with its machine time.
pub(super) fn run(session: &mut Session<'_>, file: &str) -> Outcome {
    match run_program(session, file) {
        Ok(()) if session.link.is_ending() => Outcome::Ended,
        Ok(()) => Outcome::Good,
        Err(error) => {
            session.report(&error);
            Outcome::Failed
        }
    }
}

fn run_program(session: &mut Session<'_>, file: &str) -> Result<(), Error> {
    for (name, args) in BEFORE {
        let args = args.iter().map(|a| (*a).to_owned()).collect();
        let id = begin(session, name, args)?;
        follow(session, name, id, |_, _| {})?;
        // An instance that ends takes no commands.
        if session.link.is_ending() {
            return Ok(());
        }
    }
    let id = begin(session, "task.open", vec![format!("file={file}")])?;
    follow(session, "task.open", id, |_, _| {})?;
    let id = begin(session, "task.run", Vec::new())?;
    let name = Path::new(file).file_name().map(|n| n.to_string_lossy()).unwrap_or_default();
    let mut awaited = None;
    let result = follow(session, "task.run", id, |session, now| {
        let tool = now.value("waits-for").filter(|tool| *tool != "nothing").map(str::to_owned);
        if tool != awaited {
            if let Some(tool) = &tool {
                let line = now.line();
                session.terminal.err(&format!("{name}: line {line}: waits for tool {tool}\n"));
            }
            awaited = tool;
        } else if session.terminal.is_person() {
            let (line, time) = (now.line(), now.time());
            let velocity = now.value("velocity").unwrap_or("0");
            let text = format!("{CLEAR}{name}: line {line}, {time} s, {velocity} units/s");
            session.terminal.err(&text);
        }
    });
    let clear = if session.terminal.is_person() { CLEAR } else { "" };
    if session.link.is_ending() {
        session.terminal.err(&format!("{clear}{name}: interrupted\n"));
        return result;
    }
    let time = Status::of(session)?.time().to_owned();
    let how = if result.is_ok() { "ended" } else { "failed" };
    session.terminal.err(&format!("{clear}{name}: {how} after {time} s of machine time\n"));
    result
}

/// Begins a command of the task and returns its ticket.
fn begin(session: &mut Session<'_>, name: &str, args: Vec<String>) -> Result<u64, Error> {
    match session.ask(Request::Command { name: name.to_owned(), args })? {
        Reply::Answer(answer) => answer.ticket.ok_or(Error::Unexpected),
        _ => Err(Error::Unexpected),
    }
}

/// Lets the machine run until a command has ended.
fn follow(
    session: &mut Session<'_>,
    name: &str,
    id: u64,
    mut look: impl FnMut(&mut Session<'_>, &Status),
) -> Result<(), Error> {
    while !session.link.is_ending() {
        match session.ask(Request::Ticket { id, wait: false })? {
            Reply::Ticket(TicketInfo::Pending) => {}
            Reply::Ticket(TicketInfo::Failed(why)) => {
                return Err(Error::GivenUp { command: name.into(), why: why.into() });
            }
            Reply::Ticket(_) => return Ok(()),
            _ => return Err(Error::Unexpected),
        }
        session.ask(Request::Run { ns: LOOK_NS })?;
        let now = Status::of(session)?;
        look(session, &now);
    }
    Ok(())
}

/// The answer of `task.status`.
struct Status(Vec<String>);

impl Status {
    fn of(session: &mut Session<'_>) -> Result<Self, Error> {
        let name = "task.status".to_owned();
        match session.ask(Request::Command { name, args: Vec::new() })? {
            Reply::Answer(answer) => Ok(Self(answer.lines)),
            _ => Err(Error::Unexpected),
        }
    }

    /// Returns the value of the first word `name=value`.
    fn value(&self, name: &str) -> Option<&str> {
        let words = self.0.iter().flat_map(|line| line.split(' '));
        let mut values = words.filter_map(|word| word.split_once('='));
        values.find(|(n, _)| *n == name).map(|(_, value)| value)
    }

    fn line(&self) -> &str {
        self.value("line").unwrap_or("0")
    }

    fn time(&self) -> &str {
        self.value("time").unwrap_or("0")
    }
}
