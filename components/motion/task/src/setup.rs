//! The facts of a machine: what its INI file says for the task.

use crate::{
    command_record::Letters,
    core::{Core, Rules},
    error::UserProgramError,
    worker::Files,
};
use hal_gcode::{axis::AxisMask, state::modal::MAX_SPINDLES};
use hal_ini::{Entry, Ini, beside};
use hal_job::{
    Machine, World, machine,
    number::{number, wrong},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// Seconds that a spindle may take to reach its speed, if the INI file says nothing.
const AT_SPEED_TIMEOUT: f64 = 30.0;

/// Axes of a machine without an INI file.
const XYZ: AxisMask = AxisMask(7);

/// Reads a machine's files. `letters` are those of its axes where the INI file has none. `is_virtual`: the clock is, so that
/// the instance stands still while a function works, and a run depends on no file of the user's state folder.
///
/// # Errors
/// A file cannot be read, or the startup code has an error.
pub(crate) fn read(
    ini: Option<&str>,
    letters: Option<&str>,
    is_virtual: bool,
) -> Result<(Box<Core>, Files), String> {
    // Files of the machine stay those of its folder, wherever the process goes.
    let whole = |file| std::path::absolute(file).unwrap_or_else(|_| Path::new(file).into());
    let given = ini.unwrap_or_default();
    let ini = ini.map(whole);
    let state = ini.as_deref().filter(|_| !is_virtual).and_then(hal_output::state_of_machine);
    let files = machine::Files {
        ini: ini.as_deref(),
        letters,
        state: state.as_deref(),
        ..machine::Files::default()
    };
    let mut machine = Machine::read(&files).map_err(|why| match &ini {
        // A message names the file as the user did.
        Some(path) if !path.is_file() => {
            let why = why.replace(&path.display().to_string(), given);
            format!("{why}; expected an INI file such as machine.ini")
        }
        _ => why,
    })?;
    if ini.is_none() {
        machine.settings.axes = XYZ;
    }
    let has_programs =
        machine.ini.as_ref().is_some_and(|ini| ini.section("RS274NGC").next().is_some());
    let journal = match (&ini, has_programs) {
        (Some(path), true) => Some(journal(&machine, path)),
        (Some(_), false) => state.map(|state| state.with_extension("journal")),
        (None, _) => None,
    };
    let rules = rules(&machine)?;
    machine.settings.task = true;
    let functions = machine.start_functions(is_virtual);
    let files = Files {
        parameters: machine.parameters.clone(),
        table: machine.table.clone(),
        spindle: machine.spindle_file.clone(),
        journal,
        codes: machine.codes.clone(),
        output: machine.places.as_ref().map(|places| places.output.clone()),
        named: named(&machine),
        letters: Letters::from(machine.settings.axes.0),
        functions,
    };
    let world = World { machine, hal: BTreeMap::new(), functions: None };
    Ok((Box::new(Core::new(world, rules)?), files))
}

/// Returns the file of the journal: that of the INI file, or one beside it.
fn journal(machine: &Machine, ini: &Path) -> PathBuf {
    let named = machine.ini.as_ref().and_then(|ini| ini.get("TASK", "JOURNAL"));
    named.map_or_else(|| ini.with_extension("journal"), |name| beside(&machine.folder, name))
}

/// Returns the files that the INI file includes, and whatever its values name, as a whole or as one of their words.
fn named(machine: &Machine) -> Vec<PathBuf> {
    let entries = machine.ini.iter().flat_map(Ini::entries);
    let names: BTreeSet<&str> = entries
        .flat_map(|entry| {
            let words = entry.value.split([' ', '\t', ':', '=', ',', ';', '"', '\'']);
            [entry.file.as_str(), entry.value.trim()].into_iter().chain(words)
        })
        .filter(|name| !name.is_empty())
        .collect();
    names.into_iter().map(|name| beside(&machine.folder, name)).collect()
}

fn rules(machine: &Machine) -> Result<Rules, String> {
    let ini = machine.ini.as_ref();
    let number = |section: &str, name: &str| -> Result<Option<f64>, String> {
        ini.map_or(Ok(None), |ini| number(ini, section, name))
    };
    let timeout = number("TASK", "AT_SPEED_TIMEOUT")?.filter(|t| *t > 0.0);
    let position = ini.and_then(|ini| ini.all("EMCIO", "TOOL_CHANGE_POSITION").next());
    let change_position = position.map(change_position).transpose()?;
    let mut has_top_speed = [false; MAX_SPINDLES];
    for (n, has) in has_top_speed.iter_mut().enumerate() {
        *has = number(&format!("SPINDLE_{n}"), "MAX_FORWARD_VELOCITY")?.is_some();
    }
    Ok(Rules {
        needs_homing: number("TRAJ", "NO_FORCE_HOMING")?.is_none_or(|n| n == 0.0),
        at_speed_timeout: timeout.unwrap_or(AT_SPEED_TIMEOUT),
        has_top_speed,
        change_position,
        safe_height: number("TASK", "SAFE_HEIGHT")?,
        has_full_codes: ini.map_or(Ok(true), has_full_codes).map_err(|why| why.to_string())?,
    })
}

/// Returns whether programs of users have the owner's rights in every job. They are files of the machine, in folders where
/// nobody writes from elsewhere.
fn has_full_codes(ini: &Ini) -> Result<bool, UserProgramError> {
    let Some(entry) = ini.all("REMOTE", "USER_CODES").next() else { return Ok(true) };
    match entry.value.trim() {
        "limited" => Ok(false),
        "full" => Ok(true),
        _ => Err(UserProgramError::UserCodes(Box::new(entry.clone()))),
    }
}

/// Parses three, six or nine coordinates.
fn change_position(entry: &Entry) -> Result<[Option<f64>; 9], String> {
    let wrong = || wrong(entry, "three, six or nine numbers");
    let all: Result<Vec<f64>, _> = entry.value.split_whitespace().map(str::parse).collect();
    let all = all.map_err(|_| wrong())?;
    if ![3, 6, 9].contains(&all.len()) || all.iter().any(|n| !n.is_finite()) {
        return Err(wrong());
    }
    let mut out = [None; 9];
    for (place, value) in out.iter_mut().zip(all) {
        *place = Some(value);
    }
    Ok(out)
}
