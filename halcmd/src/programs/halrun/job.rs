//! `--run`: a program on the machine, from e-stop to the end of the program.

use crate::{Error, Outcome, Session};
use hal_protocol::{Reply, Request, TicketInfo};
use std::path::Path;

/// Machine time between two looks at the program, in nanoseconds.
const LOOK_NS: u64 = 100_000_000;

/// Empties the line of a terminal.
const CLEAR: &str = "\r\x1b[K";

const RUN: &str = "task.run";

/// The commands that bring a machine from e-stop to the begin of a program.
const BEFORE: [(&str, &[&str]); 4] = [
    ("task.estop-reset", &[]),
    ("task.on", &[]),
    ("task.home", &["joint=all"]),
    ("task.mode", &["mode=auto"]),
];

/// Runs a program and tells how it ended, with its machine time.
pub(super) fn run(session: &mut Session<'_>, file: &str) -> Outcome {
    // The lines of the machine's files are behind it.
    session.stand_at("<commandline>", 0);
    match run_program(session, file) {
        Ok(()) if session.link.is_ending() => Outcome::Ended,
        Ok(()) => Outcome::Good,
        Err(error) => {
            let fault = Fault::of(&error);
            if let Some(fault) = &fault {
                session.stand_at(fault.file, fault.line);
            }
            session.report(fault.map(|f| f.error()).as_ref().unwrap_or(&error));
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
    let id = begin(session, RUN, Vec::new())?;
    let name = Path::new(file).file_name().map(|n| n.to_string_lossy()).unwrap_or_default();
    let mut awaited = None;
    let result = follow(session, RUN, id, |session, now| {
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

/// The fault of a program, whose text begins with its place: `file:line: text` or `file:line:column: text`.
struct Fault<'a> {
    file: &'a str,
    line: u32,
    column: Option<u32>,
    why: &'a str,
}

impl<'a> Fault<'a> {
    /// Returns the program's fault behind the failure of a command.
    fn of(error: &'a Error) -> Option<Self> {
        let Error::GivenUp { command, why } = error else { return None };
        let (place, why) = why.split_once(": ").filter(|_| &**command == RUN)?;
        let number = |text: &'a str| -> Option<(&'a str, u32)> {
            let (front, last) = text.rsplit_once(':')?;
            Some((front, last.parse().ok()?))
        };
        let (front, last) = number(place)?;
        let (file, line, column) = match number(front) {
            Some((file, line)) => (file, line, Some(last)),
            None => (front, last, None),
        };
        (!file.is_empty()).then_some(Self { file, line, column, why })
    }

    /// Returns the error without its place.
    fn error(&self) -> Error {
        let why = match self.column {
            Some(column) => format!("column {column}: {}", self.why),
            None => self.why.to_owned(),
        };
        Error::GivenUp { command: RUN.into(), why: why.into() }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fault_of_a_program_stands_at_its_line() {
        let said = |why: &str| {
            let error = Error::GivenUp { command: RUN.into(), why: why.into() };
            Fault::of(&error).map(|f| format!("{}:{}: {}", f.file, f.line, f.error()))
        };
        let beyond = Some("a b.ngc:3: task.run: joint 0: too far".to_owned());
        assert_eq!(said("a b.ngc:3: joint 0: too far"), beyond);
        let word = Some("sub/c.ngc:4: task.run: column 7: bad word".to_owned());
        assert_eq!(said("sub/c.ngc:4:7: bad word"), word);
        for other in ["no program is open: task.open comes first", "aborted", ":1:1: x", "a:b: c"] {
            assert_eq!(said(other), None, "{other}");
        }
    }
}
