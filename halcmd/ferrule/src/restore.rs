//! `ferrule restore`: list, comparison and restoration of earlier states of a machine's files.

use crate::{failure::Failure, options::Restore};
use hal_ini::{Ini, Purpose};
use hal_output::KeptState;
use hal_protocol::{Client, Place};
use similar::{ChangeTag, TextDiff};
use std::{
    collections::BTreeSet,
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
    process::ExitCode,
    time::SystemTime,
};
use time::OffsetDateTime;

/// Number of unchanged lines that are shown around a change.
const AROUND: usize = 2;

pub(crate) fn restore(given: &Restore) -> Result<ExitCode, Failure> {
    if !given.machine.is_file() {
        return Err(Failure::NoMachine { path: given.machine.clone() });
    }
    let files = files(&given.machine)?;
    let Some(name) = &given.file else {
        list(&files, &given.machine)?;
        return Ok(ExitCode::SUCCESS);
    };
    let Some(file) = files.iter().find(|file| is_named(file, name)) else {
        let known: Vec<String> = files.iter().map(|file| shown(file)).collect();
        return Err(Failure::NoKept { name: name.clone(), known: known.join(", ").into() });
    };
    let Some(number) = given.number else {
        list(std::slice::from_ref(file), &given.machine)?;
        return Ok(ExitCode::SUCCESS);
    };
    let known = states(file)?;
    let Some(state) = known.iter().find(|state| state.number == number) else {
        let numbers = known.iter().map(|state| state.number).collect();
        return Err(Failure::NoState { file: shown(file).into(), number, numbers });
    };
    let old = state.read().map_err(|e| Failure::file(file, &e))?;
    let now = current(file)?;
    if now.as_ref() == Some(&old) {
        hal_output::print(&format!("{}: is as it was in state {number}\n", shown(file)))?;
        return Ok(ExitCode::SUCCESS);
    }
    hal_output::print(&difference(&shown(file), now.as_deref().unwrap_or_default(), &old, number))?;
    if given.compare {
        return Ok(ExitCode::SUCCESS);
    }
    at_rest(given)?;
    if !given.yes && !crate::report::agrees("restore it?")? {
        return Ok(ExitCode::FAILURE);
    }
    hal_output::write_kept(file, &old).map_err(|e| Failure::file(file, &e))?;
    let kept = states(file)?.pop().map_or_else(String::new, |last| {
        format!("; the file that it replaced is state {}", last.number)
    });
    hal_output::print(&format!("{}: restored from state {number}{kept}\n", shown(file)))?;
    Ok(ExitCode::SUCCESS)
}

/// Keeps the files that describe a machine as they are at its start, so that a person can restore what has worked.
/// Returns the failures, which hinder no start.
pub(crate) fn keep_description(machine: &Path) -> Vec<Failure> {
    let named = named(machine).into_iter().filter(|(purpose, _)| *purpose != Purpose::Memory);
    let files: BTreeSet<PathBuf> = named.map(|(_, path)| path).collect();
    let kept = files.iter().map(|file| hal_output::keep(file).map_err(|e| Failure::file(file, &e)));
    kept.filter_map(Result::err).collect()
}

/// Returns the machine's own file, and those that its INI file includes and names, where they exist.
fn named(machine: &Path) -> Vec<(Purpose, PathBuf)> {
    let mut out = vec![(Purpose::Script, machine.to_path_buf())];
    // An INI file that has an error now may have a state without it.
    let ini = Some(machine).filter(|m| m.extension().is_some_and(|e| e == "ini"));
    if let Some(ini) = ini.and_then(|path| Ini::read(path).ok()) {
        let included = ini.entries().map(|entry| (Purpose::Script, PathBuf::from(&*entry.file)));
        out.extend(included);
        let files = ini
            .machine_files()
            .map(|(purpose, name)| (purpose, hal_ini::beside(folder(machine), name)));
        out.extend(files.filter(|(_, path)| path.is_file()));
    }
    out
}

fn folder(machine: &Path) -> &Path {
    machine.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Refuses while an instance runs: it would replace the file, or go on without it.
fn at_rest(given: &Restore) -> Result<(), Failure> {
    let place =
        Place::find(given.instance.as_deref()).map_err(|why| Failure::Instance(why.into()))?;
    match Client::connect(&place, "") {
        Ok(_) => Err(Failure::Writes { name: place.name().into() }),
        Err(_) => Ok(()),
    }
}

/// Returns the machine's own files and those that have states, in the order of their names.
fn files(machine: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut out: BTreeSet<PathBuf> = named(machine).into_iter().map(|(_, path)| path).collect();
    let whole = std::path::absolute(machine).map_err(|e| Failure::file(machine, &e))?;
    if let Some(state) = hal_output::state_of_machine(&whole) {
        let own = ["var", "spindle"].map(|ending| state.with_extension(ending));
        out.extend(own.into_iter().filter(|path| path.is_file()));
    }
    let folder = folder(machine);
    match fs::read_dir(folder.join(hal_output::STATES_FOLDER)) {
        Err(e) if e.kind() == ErrorKind::NotFound => {}
        entries => {
            let wrong = |e: &std::io::Error| Failure::file(folder, e);
            for entry in entries.map_err(|e| wrong(&e))? {
                out.insert(folder.join(entry.map_err(|e| wrong(&e))?.file_name()));
            }
        }
    }
    // One file may be named in two ways.
    let mut known = BTreeSet::new();
    let whole = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
    Ok(out.into_iter().filter(|path| known.insert(whole(path))).collect())
}

fn is_named(file: &Path, name: &Path) -> bool {
    file.ends_with(name)
        || file.canonicalize().ok().is_some_and(|f| name.canonicalize().ok() == Some(f))
}

fn shown(file: &Path) -> String {
    let file = file.strip_prefix("./").unwrap_or(file);
    file.display().to_string()
}

fn states(file: &Path) -> Result<Vec<KeptState>, Failure> {
    hal_output::states(file).map_err(|e| Failure::file(file, &e))
}

/// Reads a file as it is now; `None` if it is not there.
fn current(file: &Path) -> Result<Option<Vec<u8>>, Failure> {
    match hal_ini::file::whole(file) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        read => read.map(Some).map_err(|e| Failure::file(file, &e)),
    }
}

/// Prints the states of files, the newest first.
fn list(files: &[PathBuf], machine: &Path) -> Result<(), Failure> {
    let mut text = String::new();
    let mut last = None;
    for file in files {
        let mut states = states(file)?;
        states.reverse();
        let now = current(file)?;
        for state in states {
            let old = state.read().map_err(|e| Failure::file(file, &e))?;
            let about = match &now {
                Some(now) if *now == old => "as it is now".to_owned(),
                Some(now) => summary(now, &old),
                None => "the file is not there now".to_owned(),
            };
            let (name, number, time) = (shown(file), state.number, written(state.time));
            text.push_str(&format!("{name:32} {number:>6}  {time}  {about}\n"));
            last = last.or(Some((name, number)));
        }
    }
    let machine = shown(machine);
    match last {
        None => text = format!("{machine}: none of its files has an earlier state\n"),
        Some((name, number)) => {
            let head = ("file", "state", "written");
            text = format!("{:32} {:>6}  {:20}  difference\n{text}", head.0, head.1, head.2);
            text.push_str(&format!(
                "'ferrule restore {machine} {name} {number} --compare' shows one, without --compare it is restored\n"
            ));
        }
    }
    Ok(hal_output::print(&text)?)
}

/// Returns the numbers of lines that a restoration removes and adds.
fn summary(now: &[u8], old: &[u8]) -> String {
    let count = |tag: ChangeTag| {
        let (now, old) = (String::from_utf8_lossy(now), String::from_utf8_lossy(old));
        TextDiff::from_lines(&now, &old).iter_all_changes().filter(|c| c.tag() == tag).count()
    };
    format!("-{} +{} lines", count(ChangeTag::Delete), count(ChangeTag::Insert))
}

/// Returns the change from the file as it is now to a state, as a unified difference.
fn difference(name: &str, now: &[u8], old: &[u8], number: u32) -> String {
    let (now, old) = (String::from_utf8_lossy(now), String::from_utf8_lossy(old));
    let lines = TextDiff::from_lines(&now, &old);
    let mut shown = lines.unified_diff();
    shown
        .context_radius(AROUND)
        .header(&format!("{name} (now)"), &format!("{name} (state {number})"));
    shown.to_string()
}

/// Returns a time in UTC, as in `2026-11-28 14:03 UTC`.
fn written(time: SystemTime) -> String {
    let time = OffsetDateTime::from(time);
    let (date, hour, minute) = (time.date(), time.hour(), time.minute());
    format!("{date} {hour:02}:{minute:02} UTC")
}
