//! `apply`: applies the lines of a file to a running engine in one transaction, all or nothing.

use crate::{
    Bytes, Command, Error, Fault, Outcome, Session,
    ini::{Ini, plain},
    language::command::{Apply, Launch, LockChange},
    language::lex::{Line, Reader},
    language::syntax::Statement,
    session::{
        already::{Already, removes},
        running::Running,
        trailer::Trailer,
    },
};
use hal_protocol::{Class, Edit, Reply, Request};
use std::{
    io::Read,
    path::{Path, PathBuf},
};

/// Reason why a program cannot be started.
const START: &str = "starting a program cannot be undone";
/// Name of standard input in messages.
const STDIN: &str = "<stdin>";

/// Lines of a file that are collected for `apply`.
#[derive(Debug, Default)]
pub(crate) struct Plan {
    files: Vec<String>,
    edits: Vec<Edit>,
    /// Source text of each edit.
    texts: Vec<Text>,
    /// The line that is being read.
    line: Option<Line>,
    /// Programs that run already, one for each `loadusr` line.
    running: Vec<i32>,
    /// Text that `print` commands write after a successful apply, with file and line.
    said: Vec<(String, u32, String)>,
}

/// A line as words, and the messages that follow its failure.
#[derive(Debug)]
struct Text {
    line: Option<Line>,
    statement: Statement,
    trailer: Trailer,
}

impl Plan {
    /// Sets the line from which the next edits come.
    pub(crate) fn stand_on(&mut self, line: &Line) {
        self.line = Some(line.clone());
    }
}

impl Session<'_> {
    /// Reads a file completely, then sends all its lines in one request.
    pub(crate) fn apply(&mut self, apply: &Apply) -> Result<(), Error> {
        let (name, text) = self.text_of(apply)?;
        let ini = apply.ini.as_ref().map(|path| Ini::read(Path::new(path))).transpose()?;
        let ini_before = self.own_ini.take();
        self.own_ini = ini;
        let before = (self.place().0.to_owned(), self.place().1);
        self.plan = Some(Plan::default());
        let read = self.read(&name, Reader::new(Bytes::new(text)), false);
        let plan = self.plan.take().unwrap_or_default();
        self.own_ini = ini_before;
        let done = match read {
            Outcome::Good => self.give(plan, &name, apply.dry),
            Outcome::Failed | Outcome::Ended => Err(Error::AlreadyReported),
        };
        if done.is_err() && read != Outcome::Ended {
            self.say_of(&name, "nothing was changed");
        }
        self.stand_at(&before.0, before.1);
        done
    }

    /// Returns the path for the name of a file.
    pub(crate) fn found_at(&self, path: &str) -> PathBuf {
        self.folder.as_ref().map_or_else(|| path.into(), |f| f.join(path))
    }

    fn text_of(&self, apply: &Apply) -> Result<(String, Vec<u8>), Error> {
        if let Some(path) = &apply.file {
            let unreadable = |e| Error::NoFile { path: path.as_str().into(), why: plain(&e) };
            return Ok((
                path.clone(),
                hal_ini::file::whole(&self.found_at(path)).map_err(unreadable)?,
            ));
        }
        let mut text = Vec::new();
        let read = std::io::stdin().lock().read_to_end(&mut text);
        let why = match read {
            Ok(_) if !self.style.reads_input => return Ok((STDIN.to_owned(), text)),
            Ok(_) => "it is where this line came from".into(),
            Err(e) => plain(&e),
        };
        Err(Error::NoFile { path: STDIN.into(), why })
    }

    /// Removes the lines that say what is so already, and returns their number. After a line that removes something, a
    /// later one may have to make it again.
    fn drop_held(&mut self, plan: &mut Plan) -> Result<usize, Error> {
        let mut already = Already::ask(self.link, plan.edits.iter().map(|edit| &edit.request))?;
        let mut begins = true;
        let held: Vec<bool> = plan
            .edits
            .iter()
            .map(|edit| {
                begins &= !removes(&edit.request);
                begins && already.holds(&edit.request)
            })
            .collect();
        let mut each = held.iter();
        plan.edits.retain(|_| each.next() != Some(&true));
        let mut each = held.iter();
        plan.texts.retain(|_| each.next() != Some(&true));
        Ok(held.into_iter().filter(|held| *held).count())
    }

    /// Notes the program of a `loadusr` line, which must run from the same command line.
    fn meet(&mut self, launch: &Launch) -> Result<(), Error> {
        let taken = self.plan.as_ref().map_or_else(Vec::new, |plan| plan.running.clone());
        let why = match self.running(launch, &taken)? {
            Running::Same(pid) => {
                self.plan.get_or_insert_default().running.push(pid);
                return Ok(());
            }
            Running::No => START.into(),
            Running::Other { component, line } if line.is_empty() => {
                format!("the command line of the running '{component}' cannot be read").into()
            }
            Running::Other { component, line } => format!(
                "'{component}' runs from another command line, '{line}'; 'unloadusr {component}' ends it"
            )
            .into(),
        };
        Err(Error::NotApplied { word: "loadusr".into(), why })
    }

    fn give(&mut self, mut plan: Plan, name: &str, dry: bool) -> Result<(), Error> {
        let held = self.drop_held(&mut plan)? + plan.running.len();
        let places: Vec<(u32, u32)> = plan.edits.iter().map(|e| (e.file, e.line)).collect();
        let (files, lines) = (plan.files.clone(), plan.edits.len());
        if !dry && plan.edits.iter().any(|e| e.request == Request::Start) {
            self.send_pending()?;
        }
        let reply = match self.ask(Request::Apply { files: plan.files, edits: plan.edits, dry }) {
            Ok(Reply::Refused { edit, failure }) => {
                if let Some((file, line)) = places.get(edit as usize)
                    && let Some(file) = files.get(*file as usize)
                {
                    self.stand_at(file, *line);
                }
                if let Some(Text { line, statement, trailer }) = plan.texts.get(edit as usize) {
                    let error = Error::Engine(failure);
                    let (after, quiet) = (trailer.lines(&error), trailer.is_enough());
                    let fault = Fault { after, quiet, ..statement.blame(error) };
                    self.error(&fault, line.as_ref());
                }
                return Err(Error::AlreadyReported);
            }
            Err(Error::Engine(failure)) => {
                for text in [Some(failure.text), failure.hint].into_iter().flatten() {
                    self.say_of(name, &text);
                }
                return Err(Error::AlreadyReported);
            }
            other => other?,
        };
        let Reply::Applied { stores, lists } = reply else { return Err(Error::Unexpected) };
        let taken = format!(
            "{}, with {} and {} of functions at one boundary{}",
            counted(lines, "line"),
            counted(stores as usize, "store"),
            counted(lists as usize, "list"),
            if held > 0 {
                format!("; {} held already", counted(held, "more line"))
            } else {
                String::new()
            }
        );
        if dry {
            return self.print(&reply, |_| Some(format!("{name}: can be applied: {taken}\n")));
        }
        for (file, line, text) in plan.said {
            self.stand_at(&file, line);
            self.execute(Command::Print(Some(text)))?;
        }
        if self.style.verbose {
            self.say_of(name, &format!("applied: {taken}"));
        }
        Ok(())
    }

    fn say_of(&mut self, name: &str, text: &str) {
        self.terminal.err(&format!("{name}: {text}\n"));
    }

    /// Adds a line to the plan, or returns the reason why it cannot be part of a plan.
    pub(crate) fn plan(&mut self, statement: &Statement, command: Command) -> Result<(), Error> {
        let trailer = Trailer::of(&command);
        let request = match command {
            Command::Send(request, _) if request.class() == Class::Edit => request,
            Command::Unload(name) => Request::Unload { name },
            Command::Lock(Some(LockChange::To(level))) => Request::SetLock { level },
            Command::Lock(Some(LockChange::Without(bits))) => Request::ClearLock { bits },
            Command::Lock(None) => return Ok(()),
            Command::Source(path) => return self.source(&path),
            Command::Launch(launch) => return self.meet(&launch),
            Command::Echo(_) => return self.execute(command),
            Command::Print(text) => {
                let (file, line) = self.place();
                let said = (file.to_owned(), line, text.unwrap_or_else(|| "(null)".to_owned()));
                self.plan.get_or_insert_default().said.push(said);
                return Ok(());
            }
            other => {
                let word = statement.words().first().map_or("", String::as_str).into();
                return Err(Error::NotApplied { word, why: why_not(&other).into() });
            }
        };
        let (name, line) = (self.place().0.to_owned(), self.place().1);
        let plan = self.plan.get_or_insert_default();
        plan.texts.push(Text { line: plan.line.clone(), statement: statement.clone(), trailer });
        // The file is nearly always the last one.
        let file = plan.files.iter().rposition(|f| *f == name).unwrap_or_else(|| {
            plan.files.push(name);
            plan.files.len() - 1
        });
        plan.edits.push(Edit { file: u32::try_from(file).unwrap_or(u32::MAX), line, request });
        Ok(())
    }
}

fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Returns the reason why a command cannot be part of an all-or-nothing change.
const fn why_not(command: &Command) -> &'static str {
    match command {
        Command::UnloadAll => "ending programs cannot be undone; 'unloadrt all' unloads the rest",
        Command::Component { .. } => "a command to a component cannot be undone",
        Command::Apply(_) => "'source' takes another file in",
        Command::Send(request, _) => match request {
            Request::EndProgram { .. } => "ending a program cannot be undone",
            Request::Stop => "threads that stop lose cycles, and this is to lose none",
            Request::Run { .. } => "it moves the clock, and all of this is one moment",
            Request::Shutdown => "it would end what is to be changed",
            Request::Record { .. } | Request::EndRecord => "writing a file cannot be undone",
            Request::Flight(_) | Request::EndFlight => {
                "what the flight recorder keeps cannot be restored"
            }
            _ => "it changes neither wiring nor values",
        },
        Command::Flight(_) => "writing a file cannot be undone",
        Command::AwaitEnd(_) => "it waits, and all of this is one moment",
        _ => "it changes nothing",
    }
}
