//! Tcl files, which `tclsh` executes with the commands of HAL: the session answers its requests one by one, so that time stands
//! still while a line executes, as it does for the lines of a `.hal` file.

mod answer;
pub(crate) mod tclsh;
pub(crate) mod wire;

use crate::{Error, Outcome, Session};
use answer::Script;
use hal_protocol::{At, Request};
use rustix::io::Errno;
use std::{ffi::OsString, io, path::Path, process::ExitStatus};
use tclsh::{TCLSH, TclFile, Tclsh, TclshEvent};
use wire::Incoming;

/// Number of waits without a request after which a dry run ends an interpreter: about 10 s.
const MOST_WAITS: u32 = 2000;

impl Session<'_> {
    /// Executes a Tcl file. A dry run executes it where it can affect nothing outside.
    pub(crate) fn tcl_file(&mut self, file: &TclFile<'_>) -> Outcome {
        self.stand_at(file.shown, 0);
        match self.run_tcl(file) {
            Ok(Outcome::Failed) => {
                self.doubt_what_follows(file.shown);
                Outcome::Failed
            }
            Ok(outcome) => outcome,
            Err(error) if self.is_dry_run() => {
                self.stop_following(&At::new(file.shown, 0), &error.whole());
                Outcome::Failed
            }
            Err(error) => self.outcome_of(Err(error)),
        }
    }

    fn run_tcl(&mut self, file: &TclFile<'_>) -> Result<Outcome, Error> {
        let why = |e: &io::Error| crate::ini::plain(e);
        let unreadable = |e: &io::Error| Error::NoFile { path: file.shown.into(), why: why(e) };
        std::fs::metadata(file.path).map_err(|e| unreadable(&e))?;
        let whole = std::path::absolute(file.path).map_err(|e| unreadable(&e))?;
        let folder = tclsh::folder().map_err(|folder| Error::NoTclPackage {
            folder: folder.display().to_string().into(),
        })?;
        let mut command = tclsh::command(&folder, file.libraries);
        command.arg(&whole).args(file.args).envs(self.tcl_variables());
        let start = Tclsh::start(command, !self.style.reads_input && !self.is_dry_run());
        let mut tclsh = start.map_err(|e| match e.kind() {
            io::ErrorKind::NotFound => Error::NoTclsh,
            _ => Error::NotStarted { program: TCLSH.into(), why: why(&e) },
        })?;
        if self.is_dry_run() {
            tclsh.limit();
        }
        let none = Path::new("");
        let mut script = Script::new(
            whole.parent().unwrap_or(none),
            Path::new(file.shown).parent().unwrap_or(none),
        );
        let ended = self.follow(&mut tclsh, &mut script);
        tclsh.end();
        let Some(status) = ended.map_err(|e| Error::Tcl { text: why(&e) })? else {
            return Ok(Outcome::Ended);
        };
        match status.code() {
            _ if script.failed => Ok(Outcome::Failed),
            Some(0) => Ok(Outcome::Good),
            code => {
                self.stand_at(file.shown, 0);
                Err(Error::TclEnded { status: code })
            }
        }
    }

    /// Answers requests until the interpreter ends. Returns `None` if the instance ends first.
    fn follow(&mut self, tclsh: &mut Tclsh, script: &mut Script) -> io::Result<Option<ExitStatus>> {
        let mut incoming = Incoming::default();
        let mut waits = 0;
        loop {
            match tclsh.event()? {
                TclshEvent::Bytes(bytes) => {
                    waits = 0;
                    incoming.add(&bytes);
                    let garbled = |_| io::Error::other("it sent something else than requests");
                    while let Some(request) = incoming.next().map_err(garbled)? {
                        let answer = self.answer(script, &request);
                        tclsh.answer(&answer);
                    }
                }
                TclshEvent::Nothing => {
                    waits += 1;
                    if self.is_dry_run() && waits > MOST_WAITS {
                        return Err(io::Error::other("it does not end"));
                    }
                    // An engine in this process serves its other clients. One that ends fails the request.
                    if self.link.is_local() {
                        drop(self.ask(Request::Idle { ms: 0, flow: false }));
                    }
                }
                TclshEvent::Ended(status) => return Ok(Some(status)),
            }
            if self.link.is_ending() {
                self.ended = true;
                return Ok(None);
            }
        }
    }

    /// Returns the environment of the interpreter.
    fn tcl_variables(&self) -> Vec<(&'static str, OsString)> {
        let mut all = self.variables.clone();
        all.push(("HAL_INSTANCE", self.instance.clone().into()));
        if let Some(pass) = self.pass_number() {
            all.push(("FERRULE_PASS", pass.to_string().into()));
        }
        if self.is_dry_run() {
            all.push(("FERRULE_TRIAL", "1".into()));
        }
        all
    }

    /// Answers the requests of a Tcl script on standard input until it ends.
    pub(crate) fn serve_tcl(&mut self) -> Outcome {
        let here = std::env::current_dir().unwrap_or_default();
        let mut script = Script::new(&here, Path::new(""));
        let mut incoming = Incoming::default();
        let mut chunk = [0; 65536];
        loop {
            let n = match rustix::io::read(io::stdin(), &mut chunk) {
                Ok(0) => return Outcome::Good,
                Ok(n) => n,
                Err(Errno::INTR | Errno::AGAIN) => continue,
                Err(_) => return Outcome::Failed,
            };
            incoming.add(chunk.get(..n).unwrap_or_default());
            while let Ok(Some(request)) = incoming.next() {
                let answer = wire::sent(&self.answer(&mut script, &request));
                if self.terminal.out(&answer).is_err() {
                    return Outcome::Failed;
                }
            }
        }
    }
}
