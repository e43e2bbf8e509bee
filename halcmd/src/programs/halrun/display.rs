//! The user interface of a machine: the programs that its INI file names, and the end of the machine with them.

use super::{machine, plan::Plan};
use crate::{
    Error, Outcome, Session,
    ini::{Entry, Ini},
    language::command::Launch,
    session::program,
};
use hal_engine::ClockKind;
use std::path::Path;

/// Interfaces that execute the files of `POSTGUI_HALFILE` themselves, when their pins exist.
const READS_POSTGUI: &[&str] =
    &["axis", "gmoccapy", "gscreen", "qtvcp", "touchy", "qtdragon", "qtplasmac"];

/// Returns the entry that names the user interface.
pub(super) fn entry(ini: &Ini) -> Option<&Entry> {
    ini.all("DISPLAY", "DISPLAY").find(|entry| !entry.value.is_empty())
}

/// Tells whether the interface executes the files of `POSTGUI_HALFILE` itself.
pub(super) fn reads_postgui(ini: &Ini) -> bool {
    let name = entry(ini).map(|entry| words(entry).0).unwrap_or_default();
    let name = Path::new(&name).file_name().unwrap_or_default().to_string_lossy().into_owned();
    READS_POSTGUI.contains(&name.as_str())
}

/// Returns the program and the arguments of an entry.
fn words(entry: &Entry) -> (String, Vec<String>) {
    let mut words = entry.value.split_whitespace().map(str::to_owned);
    (words.next().unwrap_or_default(), words.collect())
}

/// Tells whether this start of the machine shows its interface: on the real clock, without an end of its own.
pub(super) fn is_shown(plan: &Plan, ini: &Ini) -> bool {
    let stays = plan.job.is_none() && plan.for_ns.is_none() && !plan.interactive;
    let is_wanted = !plan.headless && stays && plan.options.clock == ClockKind::Real;
    is_wanted && entry(ini).is_some_and(is_installed)
}

fn is_installed(entry: &Entry) -> bool {
    program::exists(&words(entry).0, |path| path.into())
}

/// Starts the interface and the applications, and waits until the interface ends. Then the files of `SHUTDOWN` are
/// executed, and the machine ends. In the background nothing waits.
pub(super) fn run(session: &mut Session<'_>, ini: &Ini, path: &Path) -> Outcome {
    let Some(display) = entry(ini) else { return Outcome::Good };
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (name, args) = words(display);
    let args = ["-ini".to_owned(), file].into_iter().chain(args).collect();
    let pid = match start(session, display, name, args) {
        Ok(pid) => pid,
        Err(error) => return session.outcome_of(Err(error)),
    };
    let delay = ini.get("APPLICATIONS", "DELAY").and_then(|v| v.trim().parse::<f64>().ok());
    if let Some(seconds) = delay.filter(|s| *s > 0.0) {
        // What ends the wait ends the next one, too.
        drop(session.await_program(pid, Some(seconds)));
    }
    for app in ini.all("APPLICATIONS", "APP").filter(|entry| !entry.value.is_empty()) {
        let (name, args) = words(app);
        if let Err(error) = start(session, app, name, args) {
            session.warn_at(&format!("Warning: {error}"));
        }
    }
    if session.style.background {
        return Outcome::Good;
    }
    let ended = session.await_program(pid, None);
    let outcome = session.outcome_of(ended);
    machine::shut_down(session, ini, path);
    if outcome == Outcome::Good { Outcome::Ended } else { outcome }
}

/// Starts a program and returns its process.
fn start(
    session: &mut Session<'_>,
    entry: &Entry,
    name: String,
    args: Vec<String>,
) -> Result<u32, Error> {
    session.stand_at(&entry.file, entry.line);
    let shown: Box<str> = name.as_str().into();
    let before = session.programs.len();
    session.launch(&Launch { program: name, args, ..Launch::default() })?;
    let started = session.programs.get(before..).and_then(<[_]>::last);
    started.map(std::process::Child::id).ok_or(Error::ProgramFailed { program: shown, status: 1 })
}
