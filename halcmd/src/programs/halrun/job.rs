//! `--run`: a program on the machine, from e-stop to the end of the program, from its first line, from another one, or
//! from the place where the last job broke off (`--resume`).

use super::{
    begin::{Begin, Job},
    waiting::{MaxWait, WAITED, WaitLook, Waiting, with_links},
};
use crate::{Error, Outcome, Session, session::prompt::was_said};
use hal_protocol::{Reply, Request, TicketInfo};
use rustix::termios::QueueSelector;

/// Machine time between two looks at the program, in nanoseconds.
const LOOK_NS: u64 = 100_000_000;

/// Empties the line of a terminal.
const CLEAR: &str = "\r\x1b[K";

/// The commands whose failures begin with a place in the program.
const PROGRAMS: [&str; 4] = ["task.run", "task.run-from", "task.recover", "task.confirm"];

/// The commands that bring a machine from e-stop to the begin of a program.
const BEFORE: [(&str, &[&str]); 4] = [
    ("task.estop-reset", &[]),
    ("task.on", &[]),
    ("task.home", &["joint=all"]),
    ("task.mode", &["mode=auto"]),
];

/// Runs a program and tells how it ended, with its machine time. Returns the exit status, if it is another than that of the
/// outcome.
pub(super) fn run(session: &mut Session<'_>, job: &Job) -> (Outcome, Option<u8>) {
    // The lines of the machine's files are behind it.
    session.stand_at("<commandline>", 0);
    match run_program(session, job) {
        Ok(_) if session.link.is_ending() => (Outcome::Ended, None),
        Ok(End::Good) => (Outcome::Good, None),
        Ok(End::NotBegun | End::Stopped) => (Outcome::Failed, None),
        Ok(End::Waited) => (Outcome::Failed, Some(WAITED)),
        Err(error) => {
            report(session, &error);
            (Outcome::Failed, None)
        }
    }
}

/// Reports an error at its line of the program, unless the log has it already.
fn report(session: &mut Session<'_>, error: &Error) {
    let fault = Fault::of(error);
    if let Error::GivenUp { why, .. } = error
        && fault.is_some()
        && was_said(why)
    {
        return;
    }
    if let Some(fault) = &fault {
        session.stand_at(fault.file, fault.line);
    }
    session.report(fault.map(|f| f.error()).as_ref().unwrap_or(error));
}

/// End of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// The program is complete.
    Good,
    /// The program did not begin, because no person confirmed it.
    NotBegun,
    /// A person has stopped it.
    Stopped,
    /// The program has waited for too long.
    Waited,
}

fn run_program(session: &mut Session<'_>, job: &Job) -> Result<End, Error> {
    if !session.is_components("task.run") {
        return Err(Error::NoTask);
    }
    if matches!(job.begin, Begin::From(..)) && !job.yes && !is_asked(session) {
        return Ok(End::NotBegun);
    }
    if job.begin == Begin::Resume {
        // Nothing moves before the person has seen what is resumed.
        complete(session, "task.recover", Vec::new())?;
        if session.link.is_ending() {
            return Ok(End::Good);
        }
        proposal(session)?;
        if !job.yes && !agrees(session, "switch on and home?") {
            return Ok(End::NotBegun);
        }
    }
    switch_on(session)?;
    let (propose, args) = match &job.begin {
        Begin::First(_) => (None, Vec::new()),
        Begin::From(_, place) => (Some("task.run-from"), place.args()),
        Begin::Resume => (Some("task.recover"), Vec::new()),
    };
    if let Begin::First(file) | Begin::From(file, _) = &job.begin
        && !session.link.is_ending()
    {
        complete(session, "task.open", vec![format!("file={file}")])?;
    }
    if let Some(propose) = propose
        && !session.link.is_ending()
    {
        complete(session, propose, args)?;
    }
    // An instance that ends takes no commands.
    if session.link.is_ending() {
        return Ok(End::Good);
    }
    let (command, args) = if propose.is_none() {
        ("task.run", Vec::new())
    } else {
        let token = proposal(session)?;
        if !job.yes && !agrees(session, "begin there?") {
            return Ok(End::NotBegun);
        }
        ("task.confirm", vec![format!("token={token}")])
    };
    let name = Status::of(session)?.value("file").unwrap_or_default().to_owned();
    watch(session, &name, (command, args), job.max_wait)
}

/// Brings the machine from e-stop to the begin of a program.
fn switch_on(session: &mut Session<'_>) -> Result<(), Error> {
    for (name, args) in BEFORE {
        if !session.link.is_ending() {
            complete(session, name, args.iter().map(|a| (*a).to_owned()).collect())?;
        }
    }
    Ok(())
}

/// Shows the start that the task proposes, and returns its token.
fn proposal(session: &mut Session<'_>) -> Result<String, Error> {
    let shown = answered(session, "task.start")?;
    for line in &shown.0 {
        session.terminal.err(&format!("{line}\n"));
    }
    shown.value("token").map(str::to_owned).ok_or(Error::Unexpected)
}

/// Asks the person at the terminal. Without one, nobody agrees.
fn agrees(session: &mut Session<'_>, question: &str) -> bool {
    if !is_asked(session) {
        return false;
    }
    // What was typed before the question is no answer to it.
    if rustix::termios::tcflush(std::io::stdin(), QueueSelector::IFlush).is_err() {
        return false;
    }
    session.terminal.err(&format!("{question} (y/N) "));
    // Without a buffer, in which a later question would find what is typed here behind the answer.
    let mut line = [0; 64];
    let read = rustix::io::retry_on_intr(|| rustix::io::read(std::io::stdin(), &mut line));
    let answer = read.ok().and_then(|n| line.get(..n)).unwrap_or_default();
    matches!(answer.trim_ascii_start().first(), Some(b'y' | b'Y'))
}

/// Returns whether a person at the terminal can be asked, and says what to do if none can.
fn is_asked(session: &mut Session<'_>) -> bool {
    let missing = if !rustix::termios::isatty(std::io::stdin()) {
        "standard input"
    } else if !session.terminal.is_person() {
        "standard error, where the question would be,"
    } else {
        return true;
    };
    session.terminal.err(&format!(
        "{missing} is no terminal, so nobody can agree: --yes begins without a question\n"
    ));
    false
}

/// Follows a program that a command begins, and tells how it ends.
fn watch(
    session: &mut Session<'_>,
    name: &str,
    (command, args): (&str, Vec<String>),
    max_wait: MaxWait,
) -> Result<End, Error> {
    let id = begin(session, command, args)?;
    let is_person = session.terminal.is_person();
    let clear = if is_person { CLEAR } else { "" };
    let mut waiting = Waiting::new(max_wait, is_person);
    let mut line = String::new();
    let mut result = follow(session, command, id, |session, now| {
        if now.line() != "0" {
            now.line().clone_into(&mut line);
        }
        match waiting.look(now, LOOK_NS) {
            WaitLook::Tell(text) => {
                let text = with_links(session, &text);
                session.terminal.err(&format!("{clear}{name}: line {line}: waits for {text}\n"));
            }
            WaitLook::TooLong(text) => {
                let (text, most) = (with_links(session, &text), waiting.most());
                session.terminal.err(&format!(
                    "{clear}{name}: line {line}: gives up after {most} s of waiting for {text}\n"
                ));
                return false;
            }
            WaitLook::Same if is_person => session.terminal.err(&progress(name, now)),
            WaitLook::Same => {}
        }
        true
    });
    let has_waited = result == Ok(false);
    if has_waited {
        complete(session, "task.abort", Vec::new())?;
        // Its end is no error any more.
        result = follow(session, command, id, |_, _| true).or(Ok(true));
    }
    if session.link.is_ending() {
        session.terminal.err(&format!("{clear}{name}: interrupted\n"));
        return result.map(|_| End::Good);
    }
    let now = Status::of(session)?;
    let (time, by) = (now.time(), now.stopped_by().filter(|_| result.is_err()));
    let how = match by {
        _ if has_waited => "given up".to_owned(),
        Some(by) => format!("stopped by {by} at line {line}"),
        None if result.is_ok() => "ended".to_owned(),
        None => "failed".to_owned(),
    };
    session.terminal.err(&format!("{clear}{name}: {how} after {time} s of machine time\n"));
    match (has_waited, by) {
        (true, _) => Ok(End::Waited),
        (false, Some(_)) => Ok(End::Stopped),
        (false, None) => result.map(|_| End::Good),
    }
}

/// Returns the line that shows a person how far a program has come.
fn progress(name: &str, now: &Status) -> String {
    let (line, time) = (now.line(), now.time());
    let velocity = now.value("velocity").unwrap_or("0");
    let left = match now.value("left").filter(|left| *left != "unknown") {
        Some(left) => format!(", about {left} s left"),
        None => String::new(),
    };
    format!("{CLEAR}{name}: line {line}, {time} s, {velocity} units/s{left}")
}

/// The fault of a program, whose text begins with its place: `file:line: text` or `file:line:column: text`.
struct Fault<'a> {
    file: &'a str,
    line: u32,
    column: Option<u32>,
    why: &'a str,
    command: &'a str,
}

impl<'a> Fault<'a> {
    /// Returns the program's fault behind the failure of a command.
    fn of(error: &'a Error) -> Option<Self> {
        let Error::GivenUp { command, why } = error else { return None };
        let (place, why) = why.split_once(": ").filter(|_| PROGRAMS.contains(&&**command))?;
        let number = |text: &'a str| -> Option<(&'a str, u32)> {
            let (front, last) = text.rsplit_once(':')?;
            Some((front, last.parse().ok()?))
        };
        let (front, last) = number(place)?;
        let (file, line, column) = match number(front) {
            Some((file, line)) => (file, line, Some(last)),
            None => (front, last, None),
        };
        (!file.is_empty()).then_some(Self { file, line, column, why, command })
    }

    /// Returns the error without its place.
    fn error(&self) -> Error {
        let why = match self.column {
            Some(column) => format!("column {column}: {}", self.why),
            None => self.why.to_owned(),
        };
        Error::GivenUp { command: self.command.into(), why: why.into() }
    }
}

/// Executes a command of the task to its end.
fn complete(session: &mut Session<'_>, name: &str, args: Vec<String>) -> Result<(), Error> {
    let id = begin(session, name, args)?;
    follow(session, name, id, |_, _| true).map(|_| ())
}

/// Begins a command of the task and returns its ticket.
fn begin(session: &mut Session<'_>, name: &str, args: Vec<String>) -> Result<u64, Error> {
    match session.ask(Request::Command { name: name.to_owned(), args })? {
        Reply::Answer(answer) => answer.ticket.ok_or(Error::Unexpected),
        _ => Err(Error::Unexpected),
    }
}

/// Lets the machine run until a command has ended, or until a look returns false. Returns whether it has ended.
fn follow(
    session: &mut Session<'_>,
    name: &str,
    id: u64,
    mut look: impl FnMut(&mut Session<'_>, &Status) -> bool,
) -> Result<bool, Error> {
    while !session.link.is_ending() {
        match session.ask(Request::Ticket { id, wait: false })? {
            Reply::Ticket(TicketInfo::Pending) => {}
            Reply::Ticket(TicketInfo::Failed(why)) => {
                return Err(Error::GivenUp { command: name.into(), why: why.into() });
            }
            Reply::Ticket(_) => return Ok(true),
            _ => return Err(Error::Unexpected),
        }
        session.ask(Request::Run { ns: LOOK_NS })?;
        let now = Status::of(session)?;
        if !look(session, &now) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Returns the answer of a command of the task.
fn answered(session: &mut Session<'_>, name: &str) -> Result<Status, Error> {
    match session.ask(Request::Command { name: name.to_owned(), args: Vec::new() })? {
        Reply::Answer(answer) => Ok(Status(answer.lines)),
        _ => Err(Error::Unexpected),
    }
}

/// The lines of an answer, with words `name=value`.
pub(super) struct Status(Vec<String>);

impl Status {
    fn of(session: &mut Session<'_>) -> Result<Self, Error> {
        answered(session, "task.status")
    }

    /// Returns the value of the first word `name=value`.
    fn value(&self, name: &str) -> Option<&str> {
        let words = self.0.iter().flat_map(|line| line.split(' '));
        let mut values = words.filter_map(|word| word.split_once('='));
        values.find(|(n, _)| *n == name).map(|(_, value)| value)
    }

    /// Returns the wait in progress: its kind, object and begin, the time at which it ends, and its text.
    pub(super) fn wait(&self) -> Option<(&str, &str, &str)> {
        let line = self.0.iter().find_map(|line| line.strip_prefix("wait for="))?;
        let (words, rest) = line.split_once(" until=")?;
        let (until, text) = rest.split_once(' ')?;
        Some((words, until, text))
    }

    /// Returns who has stopped the last job, if somebody has.
    fn stopped_by(&self) -> Option<&str> {
        match self.value("ended-by") {
            Some("abort") => Some("an abort"),
            Some("estop") => Some("e-stop"),
            Some("off") => Some("switching off"),
            _ => None,
        }
    }

    fn line(&self) -> &str {
        self.value("line").unwrap_or("0")
    }

    fn time(&self) -> &str {
        self.value("time").unwrap_or("0")
    }
}

#[cfg(test)]
impl Status {
    pub(super) const fn new(lines: Vec<String>) -> Self {
        Self(lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fault_of_a_program_stands_at_its_line() {
        let said = |why: &str| {
            let error = Error::GivenUp { command: "task.run".into(), why: why.into() };
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
