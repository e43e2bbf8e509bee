//! Programs that a script starts.

use crate::{Error, Outcome, Session, language::command::Launch, session::tcl::tclsh};
use hal_protocol::{ComponentInfo, ComponentState, Kind, Lock, Reply, Request};
use rustix::{
    fs::FileType,
    process::{Pid, WaitId, WaitIdOptions, waitid},
};
use std::{
    os::fd::AsFd,
    path::PathBuf,
    process::{Child, Command, ExitStatus, Stdio},
};

/// Number of polls after which a message says that the session is waiting for a component.
const SILENT_POLLS: u32 = 100;
const POLL_MS: u32 = 10;
/// Longest sleep that is machine time, in seconds.
const MAX_SLEEP: f64 = 1e6;

impl Session<'_> {
    /// Executes `loadusr`.
    pub(crate) fn launch(&mut self, launch: &Launch) -> Result<(), Error> {
        let program = launch.program.as_str();
        if self.state()?.lock.0 & Lock::LOAD.0 != 0 {
            return Err(Error::Locked);
        }
        let base = launch.name();
        let of_screen = self.is_postgui && launch.is_of_screen();
        if self.stand_ins.replaces(base) || of_screen && self.stand_ins.is_headless() {
            self.note(&format!("a stand-in is there for '{base}'"));
            return Ok(());
        }
        if let Some(ns) = launch.sleeps().filter(|_| launch.until_end)
            && self.sleeps_on_the_clock
        {
            // Machine time passes, as it does on the real clock, and no time of the person.
            return self.ask(Request::Run { ns }).map(|_| ());
        }
        self.reap();
        let expected = launch.expected();
        let before = if launch.until_ready { self.components()? } else { Vec::new() };
        let mut child = match self.spawn(launch) {
            Ok(child) => child,
            Err(error) => {
                let why = crate::ini::plain(&error);
                self.warn_at(&Error::NotStarted { program: program.into(), why }.to_string());
                return Self::not_started(launch, expected);
            }
        };
        let pid = i32::try_from(child.id()).unwrap_or(0);
        if let Err(error) = self.ask(Request::Adopt { pid, program: program.to_owned() }) {
            // The instance does not know the program and would not end it.
            if child.kill().is_ok() {
                drop(child.wait());
            }
            return Err(error);
        }
        self.note(&format!("Program '{program}' started"));
        let result = if launch.until_ready {
            let ready = self.until_ready(&mut child, program, &expected, &before);
            if ready.is_err() && self.stand_ins.is_simulated() && !self.link.is_ending() {
                let text = format!("--stub {base} puts pins in the place of this program");
                self.warn_at(&text);
            }
            ready
        } else if launch.until_end {
            self.until_end(&mut child, launch)
        } else {
            Ok(())
        };
        self.programs.push(child);
        self.reap();
        result
    }

    /// Runs haltcl on this process's standard input, until it ends.
    pub(crate) fn tcl_prompt(&mut self) -> Outcome {
        self.style.reads_input = false;
        let haltcl = Launch {
            program: "haltcl".to_owned(),
            until_end: true,
            ignore_status: true,
            ..Launch::default()
        };
        let ended = self.launch(&haltcl);
        self.outcome_of(ended)
    }

    /// Executes `waitusr`.
    pub(crate) fn await_end(&mut self, name: &str) -> Result<(), Error> {
        let mut waited = false;
        loop {
            let wait = match self.component_of(name)? {
                None if waited => {
                    self.note(&format!("Component '{name}' finished"));
                    return Ok(());
                }
                None => {
                    self.note(&format!("component '{name}' not found or already exited"));
                    return Ok(());
                }
                Some(found) if found.realtime => {
                    return Err(Error::NotAProgram { name: name.into() });
                }
                Some(found) => {
                    if !waited {
                        self.note(&format!("Waiting for component '{name}'"));
                    }
                    Request::Await { ms: POLL_MS, pid: found.pid.unwrap_or(0) }
                }
            };
            waited = true;
            self.ask(wait)?;
        }
    }

    /// Lets the instance run until a program of this session has ended, or for a time.
    pub(crate) fn await_program(&mut self, id: u32, seconds: Option<f64>) -> Result<(), Error> {
        let pid = i32::try_from(id).unwrap_or(0);
        let mut waited = 0.0;
        while self.programs.iter().any(|child| child.id() == id && !has_ended(child)) {
            if seconds.is_some_and(|most| waited >= most) {
                return Ok(());
            }
            waited += f64::from(POLL_MS) / 1000.0;
            self.ask(Request::Await { ms: POLL_MS, pid })?;
        }
        self.reap();
        Ok(())
    }

    /// Removes programs that have ended from the list.
    pub(crate) fn reap(&mut self) {
        if self.programs.iter().any(has_ended) {
            self.let_engine_see_ends();
        }
        self.programs.retain_mut(|child| matches!(child.try_wait(), Ok(None)));
    }

    fn spawn(&self, launch: &Launch) -> std::io::Result<Child> {
        let program = beside(&launch.program).unwrap_or_else(|| PathBuf::from(&launch.program));
        let mut command = Command::new(program);
        command.args(&launch.args).env("HAL_INSTANCE", &self.instance);
        if let Some(path) = python_path() {
            command.env("PYTHONPATH", path);
        }
        let packages = tclsh::folder().ok().and_then(|folder| tclsh::packages(&folder));
        command.envs(packages.map(|folders| (tclsh::PACKAGES, folders)));
        command.envs(self.variables.iter().map(|(name, value)| (name, value)));
        if self.style.reads_input {
            command.stdin(Stdio::null());
        }
        if self.style.background && !launch.until_end {
            if !is_file(std::io::stdout()) {
                command.stdout(Stdio::null());
            }
            if !is_file(std::io::stderr()) {
                command.stderr(Stdio::null());
            }
        }
        hal_engine::spawn(&mut command)
    }

    /// Returns the result for a program that cannot be started: the same as for one that fails at
    /// once.
    fn not_started(launch: &Launch, component: String) -> Result<(), Error> {
        let program: Box<str> = launch.program.as_str().into();
        if launch.until_ready {
            Err(Error::NotReady { program, component: component.into(), failed: true })
        } else if launch.until_end && !launch.ignore_status {
            Err(Error::ProgramFailed { program, status: 1 })
        } else {
            Ok(())
        }
    }

    fn until_ready(
        &mut self,
        child: &mut Child,
        program: &str,
        component: &str,
        before: &[ComponentInfo],
    ) -> Result<(), Error> {
        let mut polls = 0;
        let result = loop {
            let found = self.component_of(component)?;
            if found.is_some_and(|c| c.state == ComponentState::Ready) {
                self.note(&format!("Component '{component}' ready"));
                break Ok(());
            }
            if let Some(status) = self.ended(child) {
                break Err(Error::NotReady {
                    program: program.into(),
                    component: component.into(),
                    failed: !status.is_some_and(|s| s.success()),
                });
            }
            self.ask(Request::Idle { ms: POLL_MS, flow: false })?;
            polls += 1;
            if polls == SILENT_POLLS {
                self.warn_at(&format!("Waiting for component '{component}' to become ready."));
                if self.stand_ins.is_simulated() {
                    self.warn_at("it may wait for hardware or a screen that is not here");
                }
                for other in self.components()?.iter().filter(|c| !before.contains(c)) {
                    self.warn_at(&format!(
                        "While waiting for component '{component}', component '{}' loaded",
                        other.name
                    ));
                }
            } else if polls > SILENT_POLLS && polls % 10 == 0 && !self.style.json {
                self.terminal.err(".");
            }
        };
        if polls > SILENT_POLLS && !self.style.json {
            self.terminal.err("\n");
        }
        result
    }

    fn until_end(&mut self, child: &mut Child, launch: &Launch) -> Result<(), Error> {
        let program = launch.program.as_str();
        let pid = i32::try_from(child.id()).unwrap_or(0);
        let status = loop {
            match self.ended(child) {
                Some(status) => break status,
                None => self.ask(Request::Await { ms: POLL_MS, pid })?,
            };
        };
        self.note(&format!("Program '{program}' finished"));
        match status.and_then(|s| s.code()) {
            _ if launch.ignore_status => Ok(()),
            Some(0) => Ok(()),
            Some(status) => Err(Error::ProgramFailed { program: program.into(), status }),
            None => Err(Error::ProgramKilled { program: program.into() }),
        }
    }

    /// Returns the exit status of a child that has ended (`None` if another part of the process has
    /// collected it).
    fn ended(&mut self, child: &mut Child) -> Option<Option<ExitStatus>> {
        if !has_ended(child) {
            return None;
        }
        self.let_engine_see_ends();
        Some(child.try_wait().ok().flatten())
    }

    /// Lets an engine in this process report programs that a signal ended, before their exit status is collected.
    fn let_engine_see_ends(&mut self) {
        if self.link.is_local() {
            // An engine that is ending reports nothing more.
            drop(self.ask(Request::Idle { ms: 0, flow: false }));
        }
    }

    pub(crate) fn component_of(&mut self, name: &str) -> Result<Option<ComponentInfo>, Error> {
        match self.ask(Request::Component { name: name.to_owned() })? {
            Reply::Components(list) => Ok(list.into_iter().next()),
            _ => Err(Error::Unexpected),
        }
    }

    pub(crate) fn components(&mut self) -> Result<Vec<ComponentInfo>, Error> {
        let all = Request::List { kind: Kind::Components, patterns: Vec::new(), ty: None };
        match self.ask(all)? {
            Reply::Components(list) => Ok(list),
            _ => Err(Error::Unexpected),
        }
    }
}

/// Converts seconds of a sleep, which are finite and not negative.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded by MAX_SLEEP")]
fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

/// Returns whether a child has ended, without collecting its exit status.
fn has_ended(child: &Child) -> bool {
    let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    !matches!(waitid(WaitId::Pid(Pid::from_child(child)), look), Ok(None))
}

/// Returns whether output goes to a regular file, not to a terminal or to a pipe with a waiting
/// reader.
pub(crate) fn is_file(fd: impl AsFd) -> bool {
    rustix::fs::fstat(fd).is_ok_and(|s| FileType::from_raw_mode(s.st_mode) == FileType::RegularFile)
}

/// Returns whether a program exists: by its path, beside the running one, or in PATH. `found_at` gives the file that a
/// path means.
pub(crate) fn exists(program: &str, found_at: impl FnOnce(&str) -> PathBuf) -> bool {
    if program.contains('/') {
        return found_at(program).is_file();
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    beside(program).is_some() || std::env::split_paths(&path).any(|f| f.join(program).is_file())
}

/// Returns the path on which Python looks for modules, with the folder of Ferrule's own modules first; `None` if there
/// is no such folder.
fn python_path() -> Option<std::ffi::OsString> {
    let here = std::env::current_exe().ok()?;
    let own = here.parent()?.join("python");
    let before = std::env::var_os("PYTHONPATH").filter(|path| !path.is_empty());
    let paths = std::iter::once(own.clone()).chain(before.iter().flat_map(std::env::split_paths));
    own.is_dir().then(|| std::env::join_paths(paths).ok()).flatten()
}

impl Launch {
    /// Returns the time that `sleep SECONDS` sleeps, in nanoseconds; several times add up.
    fn sleeps(&self) -> Option<u64> {
        let is_sleep = self.program.rsplit('/').next() == Some("sleep") && !self.args.is_empty();
        let seconds =
            |arg: &String| arg.parse::<f64>().ok().filter(|s| (0.0..=MAX_SLEEP).contains(s));
        let all = self.args.iter().map(seconds).sum::<Option<f64>>().filter(|_| is_sleep)?;
        Some(nanoseconds(all))
    }

    /// Returns whether a program that a file of `POSTGUI_HALFILE` starts belongs to the screen: it stays, and is none of ours.
    pub(crate) fn is_of_screen(&self) -> bool {
        !self.until_end && beside(&self.program).is_none()
    }
}

/// Returns the program of this name beside the running one.
fn beside(program: &str) -> Option<PathBuf> {
    if program.contains('/') {
        return None;
    }
    let here = std::env::current_exe().ok()?;
    let found = here.parent()?.join(program);
    found.is_file().then_some(found)
}
