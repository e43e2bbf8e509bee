//! Execution of commands.

use crate::{
    Command, Error, Session, check,
    language::command::{LockChange, SaveKind, ShowKind, StatusKind},
    language::hint::nearest,
    manual::explain,
    manual::help,
    manual::man,
    show,
    show::list,
    show::published,
    show::save,
    show::status,
};
use hal_output::{Unwritten, Whole};
use hal_protocol::{Failure, Kind, Lock, Reply, Request, StatusInfo, TicketInfo, Type};
use serde_json::{Value, json};
use std::{
    io::{self, Write},
    path::Path,
};

/// Failure code for a name that does not exist.
const ENOENT: i32 = -2;

/// Reason why a command was not completed when the wait for it ends.
const STOPPED: &str = "the threads have stopped before it was carried out";

/// Sections of `show`, in order.
const SECTIONS: &[(Kind, &str)] = &[
    (Kind::Components, "Loaded HAL Components:"),
    (Kind::Pins, "Component Pins:"),
    (Kind::PinAliases, "Pin Aliases:"),
    (Kind::Signals, "Signals:"),
    (Kind::Params, "Parameters:"),
    (Kind::ParamAliases, "Parameter Aliases:"),
    (Kind::Functs, "Exported Functions:"),
    (Kind::Threads, "Realtime Threads:"),
];

impl Session<'_> {
    pub(crate) fn execute(&mut self, command: Command) -> Result<(), Error> {
        match command {
            Command::Send(
                Request::Load { module, .. } | Request::LoadForeign { module, .. },
                _,
            ) if self.stand_ins.replaces(&module) => {
                self.note(&format!("a stand-in is there for '{module}'"));
            }
            Command::Send(request, note) => {
                let told = self.style.verbose || self.returned.is_some();
                let set = if told { self.set_note(&request)? } else { None };
                self.ask(request)?;
                self.done(set.or(note).as_deref());
            }
            Command::Value(request) => {
                let reply = self.ask(request)?;
                self.print(&reply, |reply| match reply {
                    Reply::Value(value) => Some(format!("{value}\n")),
                    Reply::Snapshot(snapshot) => Some(published::json(snapshot)),
                    _ => None,
                })?;
            }
            Command::TypeOf(request) => {
                let reply = self.ask(request)?;
                self.print(&reply, |reply| match reply {
                    Reply::Value(value) => Some(format!("{}\n", value.ty().name())),
                    _ => None,
                })?;
            }
            Command::Unload(name) => self.unload(name)?,
            Command::UnloadAll => {
                self.ask(Request::EndProgram { name: None })?;
                self.ask(Request::UnloadAll)?;
            }
            Command::Launch(launch) => self.launch(&launch)?,
            Command::AwaitEnd(name) => self.await_end(&name)?,
            Command::Show(kind, ty, patterns) => self.show(kind, ty, &patterns)?,
            Command::List(kind, patterns) => {
                let reply = self.ask(Request::List { kind, patterns, ty: None })?;
                self.listing(&reply, list::names)?;
            }
            Command::Save(kind, file) => self.save(kind, file.as_deref())?,
            Command::Status(kind) => self.status(kind)?,
            Command::Check(words) => {
                let before = check::Before { ini: None, json: self.style.json };
                let status =
                    self.printed_by(|link, terminal| check::main(&words, before, link, terminal))?;
                if status > 1 {
                    return Err(Error::AlreadyReported);
                }
            }
            Command::Explain(words) => {
                self.printed_by(|_, terminal| explain::main(&words, terminal))?;
            }
            Command::Flight(what) => self.flight(what)?,
            Command::Man(words) => {
                self.printed_by(|_, terminal| man::main(&words, terminal))?;
            }
            Command::Order(subject, script) => self.order(&subject, script)?,
            Command::Graph(subject, wanted, format, file) => {
                self.graph(&subject, &wanted, format, file.as_deref())?;
            }
            Command::Print(text) => {
                let text = text.as_deref().unwrap_or("(null)");
                self.warn_at(&format!("HALCMD MSG: {text}"));
            }
            Command::Echo(on) => {
                let text = if on { "Echo on\n" } else { "Echo off\n" };
                self.text(text, || json!({ "echo": on }))?;
                self.style.echo = on;
            }
            Command::Source(path) => self.source(&path)?,
            Command::Apply(apply) => self.apply(&apply)?,
            Command::Help(about) => {
                let about = about.as_deref();
                if let Some(name) = about.filter(|name| self.is_components(name)) {
                    let kind = ShowKind::Of(Kind::Commands);
                    return self.show(Some(kind), None, &[name.to_owned()]);
                }
                // As in LinuxCNC, missing help is a message and not an error.
                let text = help::help(about).unwrap_or_else(|e| format!("{}\n", e.whole()));
                self.text(&text, || help::object(about))?;
            }
            Command::Watch(watch) => self.watch(&watch)?,
            Command::Meter(name) => self.meter(name)?,
            Command::Completion(text) => self.text(text, || json!({ "completion": text }))?,
            Command::Lock(change) => self.lock(change)?,
            Command::SetExact => self.set_exact()?,
            Command::Component { name, args, wait } => self.component(name, args, wait)?,
        }
        Ok(())
    }

    /// Returns whether this is a command of a loaded component.
    pub(crate) fn is_components(&mut self, name: &str) -> bool {
        // Help needs no instance.
        let mut list = || {
            let patterns = vec![name.to_owned()];
            self.ask(Request::List { kind: Kind::Commands, patterns, ty: None }).ok()
        };
        name.contains('.') && matches!(list(), Some(Reply::Commands(found)) if !found.is_empty())
    }

    /// Returns the message of a request that sets a value.
    fn set_note(&mut self, request: &Request) -> Result<Option<String>, Error> {
        let (what, name, value) = match request {
            Request::Set { name, value } => {
                let patterns = vec![name.clone()];
                let pins = self.ask(Request::List { kind: Kind::Pins, patterns, ty: None })?;
                let is_pin = matches!(&pins, Reply::Items(pins) if !pins.is_empty());
                (if is_pin { "Pin" } else { "Parameter" }, name, value)
            }
            Request::SetSignal { name, value } => ("Signal", name, value),
            _ => return Ok(None),
        };
        Ok(Some(format!("{what} '{name}' set to {value}")))
    }

    /// Prints the `-v` message of a command.
    fn done(&mut self, note: Option<&str>) {
        for line in note.unwrap_or_default().lines() {
            self.note(line);
        }
    }

    /// Prints a reply in words, or with `--json` as it is.
    pub(crate) fn print(
        &mut self,
        reply: &Reply,
        words: impl FnOnce(&Reply) -> Option<String>,
    ) -> Result<(), Error> {
        let text = if self.style.json {
            format!("{}\n", serde_json::to_string(reply).map_err(|_| Error::Unexpected)?)
        } else {
            words(reply).ok_or(Error::Unexpected)?
        };
        Ok(self.out(&text)?)
    }

    /// Prints a text, or with `--json` an object.
    fn text(&mut self, text: &str, object: impl FnOnce() -> Value) -> Result<(), Error> {
        let text = if self.style.json { format!("{}\n", object()) } else { text.to_owned() };
        Ok(self.out(&text)?)
    }

    /// Prints a listing like [`Self::print`], unless `-Q` suppresses it.
    fn listing(
        &mut self,
        reply: &Reply,
        words: impl FnOnce(&Reply) -> String,
    ) -> Result<(), Error> {
        if self.style.silent && self.returned.is_none() {
            Ok(())
        } else {
            self.print(reply, |reply| Some(words(reply)))
        }
    }

    fn unload(&mut self, name: String) -> Result<(), Error> {
        let Reply::Components(found) = self.ask(Request::Component { name: name.clone() })? else {
            return Err(Error::Unexpected);
        };
        let Some(found) = found.first() else { return Err(self.not_loaded(&name)?) };
        if found.realtime {
            let note = format!("Realtime module '{name}' unloaded");
            self.ask(Request::Unload { name })?;
            self.done(Some(&note));
        } else {
            self.ask(Request::EndProgram { name: Some(name) })?;
        }
        Ok(())
    }

    /// Returns the error for an unknown component, with the nearest name.
    fn not_loaded(&mut self, name: &str) -> Result<Error, Error> {
        let all = Request::List { kind: Kind::Components, patterns: Vec::new(), ty: None };
        let Reply::Components(list) = self.ask(all)? else { return Err(Error::Unexpected) };
        let near = nearest(name, list.iter().map(|c| c.name.as_str()));
        Ok(Error::NotLoaded { name: name.into(), near })
    }

    fn show(
        &mut self,
        wanted: Option<ShowKind>,
        ty: Option<Type>,
        patterns: &[String],
    ) -> Result<(), Error> {
        let aliases = |kind| matches!(kind, Kind::PinAliases | Kind::ParamAliases);
        let mut sections: Vec<(Kind, &str)> = match wanted {
            None => SECTIONS.to_vec(),
            Some(ShowKind::Aliases) => SECTIONS.iter().copied().filter(|s| aliases(s.0)).collect(),
            Some(ShowKind::Of(kind)) => SECTIONS.iter().copied().filter(|s| s.0 == kind).collect(),
        };
        if let (true, Some(ShowKind::Of(kind))) = (sections.is_empty(), wanted) {
            let title = match kind {
                Kind::Workers => "Workers:",
                Kind::Snapshots => "Snapshots:",
                _ => "Commands:",
            };
            sections.push((kind, title));
        }
        let script = self.style.script;
        for (kind, title) in sections {
            let reply = self.ask(Request::List { kind, patterns: patterns.to_vec(), ty })?;
            self.listing(&reply, |reply| match reply {
                Reply::Commands(list) if patterns.is_empty() => show::summaries(list),
                reply => show::section(reply, title, script),
            })?;
        }
        Ok(())
    }

    fn save(&mut self, kind: SaveKind, file: Option<&str>) -> Result<(), Error> {
        let text = save::write(kind, &mut |request| self.ask(request))?;
        match file {
            None if self.style.silent && self.returned.is_none() => {}
            None => self.text(&text, || json!({ "save": text.lines().collect::<Vec<_>>() }))?,
            Some(file) => written(file, &text)?,
        }
        Ok(())
    }

    fn status(&mut self, kind: StatusKind) -> Result<(), Error> {
        let reply = self.ask(Request::Status)?;
        let threads = if matches!(kind, StatusKind::All | StatusKind::Instance) && !self.style.json
        {
            let all = Request::List { kind: Kind::Threads, patterns: Vec::new(), ty: None };
            match self.ask(all)? {
                Reply::Threads(list) => list,
                _ => return Err(Error::Unexpected),
            }
        } else {
            Vec::new()
        };
        let wait = self.wait_of(kind);
        self.listing(&reply, |reply| match reply {
            Reply::Status(status) => status::text(status, &threads, wait.as_deref(), kind),
            _ => String::new(),
        })
    }

    /// Returns what the job or motion waits for, as the commands `task.status` and `motion.status` tell it.
    fn wait_of(&mut self, kind: StatusKind) -> Option<String> {
        let is_shown = matches!(kind, StatusKind::All | StatusKind::Instance);
        if !is_shown || self.style.json || self.dry_run.is_some() {
            return None;
        }
        let list =
            Request::List { kind: Kind::Commands, patterns: vec!["*.status".to_owned()], ty: None };
        let Ok(Reply::Commands(commands)) = self.ask(list) else { return None };
        // The causes of stops stay for the client that asks for them.
        let known: [(&str, &[&str]); 2] =
            [("task.status", &[]), ("motion.status", &["stops=FALSE"])];
        let (name, args) =
            known.into_iter().find(|(name, _)| commands.iter().any(|c| c.name == *name))?;
        let args = args.iter().map(|arg| (*arg).to_owned()).collect();
        let request = Request::Command { name: name.to_owned(), args };
        let Ok(Reply::Answer(answer)) = self.ask(request) else { return None };
        answer.lines.iter().find_map(|line| line.strip_prefix("wait ")).map(str::to_owned)
    }

    fn lock(&mut self, change: Option<LockChange>) -> Result<(), Error> {
        let (request, locks) = match change {
            None => return Ok(()),
            Some(LockChange::To(level)) => (Request::SetLock { level }, level != Lock::NONE),
            Some(LockChange::Without(bits)) => (Request::ClearLock { bits }, false),
        };
        self.ask(request)?;
        self.note(if locks { "Locking completed" } else { "Unlocking completed" });
        Ok(())
    }

    /// Returns the state of the instance.
    pub(crate) fn state(&mut self) -> Result<StatusInfo, Error> {
        match self.ask(Request::Status)? {
            Reply::Status(status) => Ok(*status),
            _ => Err(Error::Unexpected),
        }
    }

    fn set_exact(&mut self) -> Result<(), Error> {
        if self.state()?.threads.active > 0 {
            return Err(Error::ThreadsExist);
        }
        self.info("Warning: setexact_for_test_suite_only is for test suites.");
        self.info("Warning: periods are exact here in any case.");
        Ok(())
    }

    /// Returns the error that no component offers this command, or else the command's own failure.
    fn unknown(&mut self, name: &str, failure: Failure) -> Error {
        let all = Request::List { kind: Kind::Commands, patterns: Vec::new(), ty: None };
        match self.ask(all) {
            Ok(Reply::Commands(list)) if list.iter().all(|c| c.name != name) => {
                let near = nearest(name, list.iter().map(|c| c.name.as_str()));
                Error::UnknownCommand { word: name.into(), near }
            }
            _ => Error::Engine(failure),
        }
    }

    fn component(&mut self, name: String, args: Vec<String>, wait: bool) -> Result<(), Error> {
        let reply = match self.ask(Request::Command { name: name.clone(), args }) {
            Err(Error::Engine(failure)) if failure.code == ENOENT => {
                return Err(self.unknown(&name, failure));
            }
            other => other?,
        };
        self.print(&reply, |reply| match reply {
            Reply::Answer(answer) => {
                Some(answer.lines.iter().map(|line| format!("{line}\n")).collect())
            }
            _ => None,
        })?;
        let Reply::Answer(answer) = reply else { return Ok(()) };
        let waits = wait || self.style.wait || answer.awaited;
        let Some(id) = answer.ticket else { return Ok(()) };
        if !waits {
            return self.early_refusal(&name, id);
        }
        match self.ask(Request::Ticket { id, wait: true })? {
            Reply::Ticket(TicketInfo::Failed(why)) => {
                Err(Error::GivenUp { command: name.into(), why: why.into() })
            }
            // The threads have stopped, so nothing will complete the command.
            Reply::Ticket(TicketInfo::Pending) if !self.link.is_ending() => {
                Err(Error::GivenUp { command: name.into(), why: STOPPED.into() })
            }
            Reply::Ticket(_) => Ok(()),
            _ => Err(Error::Unexpected),
        }
    }
}

/// Writes a text to a file. The old content stays until the new one is complete.
pub(crate) fn written(file: &str, text: &str) -> Result<(), Error> {
    let why = |e: &io::Error| crate::ini::plain(e);
    let mut out = Whole::create(Path::new(file))
        .map_err(|e| Error::NoDestination { path: file.into(), why: why(&e) })?;
    out.write_all(text.as_bytes()).and_then(|()| out.finish()).map_err(|e| {
        if e.kind() == io::ErrorKind::BrokenPipe {
            hal_output::lose_reader();
            return Unwritten::ReaderGone.into();
        }
        Error::NotWritten { path: file.into(), why: why(&e) }
    })
}
