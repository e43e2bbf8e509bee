//! `ferrule restore`: states of a machine's files before their last writes, and the way back to one of them.

use crate::{failure::Failure, options::Restore};
use hal_ini::Ini;
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

/// Entries of an INI file that name files which the machine writes, or a part of its description.
const NAMED: [(&str, &str); 6] = [
    ("EMCIO", "TOOL_TABLE"),
    ("EMCIO", "SPINDLE_FILE"),
    ("RS274NGC", "PARAMETER_FILE"),
    ("HAL", "HALFILE"),
    ("HAL", "POSTGUI_HALFILE"),
    ("HAL", "SHUTDOWN"),
];
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
    let states = states(file)?;
    let Some(state) = states.iter().find(|state| state.number == number) else {
        let numbers = states.iter().map(|state| state.number).collect();
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
    if !given.yes && !crate::report::agrees("write it back?")? {
        return Ok(ExitCode::FAILURE);
    }
    hal_output::write_kept(file, &old).map_err(|e| Failure::file(file, &e))?;
    let kept = states_now(file)?
        .map_or_else(String::new, |last| format!("; what it was is state {}", last.number));
    hal_output::print(&format!("{}: written back from state {number}{kept}\n", shown(file)))?;
    Ok(ExitCode::SUCCESS)
}

/// Keeps the files that describe a machine as they are at its start, so that there is a way back to what has worked.
/// Returns what cannot be kept, which hinders no start.
pub(crate) fn keep_description(machine: &Path) -> Vec<Failure> {
    let Ok(files) = files(machine) else { return Vec::new() };
    let kept = files.iter().map(|file| hal_output::keep(file).map_err(|e| Failure::file(file, &e)));
    kept.filter_map(Result::err).collect()
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
    let folder = machine.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut out = BTreeSet::from([machine.to_path_buf()]);
    if machine.extension().is_some_and(|e| e == "ini") {
        // An INI file that has an error now may have a state without it.
        if let Ok(ini) = Ini::read(machine) {
            out.extend(ini.entries().map(|entry| PathBuf::from(&*entry.file)));
            for (section, name) in NAMED {
                let words =
                    ini.all(section, name).filter_map(|e| e.value.split_whitespace().next());
                let inside = words.map(|word| folder.join(word)).filter(|path| path.is_file());
                out.extend(inside);
            }
        }
        let whole = std::path::absolute(machine).map_err(|e| Failure::file(machine, &e))?;
        if let Some(state) = hal_output::state_of_machine(&whole) {
            let own = ["var", "spindle"].map(|ending| state.with_extension(ending));
            out.extend(own.into_iter().filter(|path| path.is_file()));
        }
    }
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

fn states_now(file: &Path) -> Result<Option<KeptState>, Failure> {
    Ok(states(file)?.pop())
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
        None => text = format!("{machine}: none of its files has a state of before\n"),
        Some((name, number)) => {
            let head = ("file", "state", "written");
            text = format!("{:32} {:>6}  {:20}  difference\n{text}", head.0, head.1, head.2);
            text.push_str(&format!(
                "'ferrule restore {machine} {name} {number} --compare' shows one, without --compare it writes it back\n"
            ));
        }
    }
    Ok(hal_output::print(&text)?)
}

/// Returns the numbers of lines that a way back takes away and brings.
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
