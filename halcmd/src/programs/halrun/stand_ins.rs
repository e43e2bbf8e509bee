//! Stand-ins that are asked for, and the proposal of some after a start that failed.

use super::{
    Files, display,
    folders::{Folders, LINUXCNC_FOLDER},
    plan::{Plan, Script},
};
use crate::{
    Error, Outcome, Session,
    ini::Ini,
    session::dry_run::DryRun,
    standin::{self, Asked, StandIns, Start},
};
use hal_engine::ClockKind;
use hal_protocol::At;
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};
use tracing::subscriber::{NoSubscriber, with_default};

/// Largest number of sourced files in which hardware and screens are looked for.
const MAX_FILES: usize = 64;

/// Prepares the stand-ins of a machine, before its files are executed.
pub(super) fn prepare(session: &mut Session<'_>, plan: &Plan, files: &Files) -> Outcome {
    let Some((path, ini)) = files_of(plan) else { return Outcome::Good };
    let asked = asked(plan, files);
    let needed = asked.is_explicit() || needs(plan, files, &path, &asked);
    let found =
        if needed { of(&path, ini.as_deref(), plan, &asked) } else { Ok(StandIns::default()) };
    // The start itself says what is wrong with the files.
    session.stand_ins = found.unwrap_or_default().with(Start {
        simulated: plan.options.simulate,
        ports: plan.healthy,
        homes: plan.options.clock == ClockKind::Virtual,
        headless: asked.is_headless(),
    });
    let begun = session.begin_stand_ins(&At::new(&path, 0));
    session.outcome_of(begun)
}

/// Says which stand-ins would let a machine start that did not.
pub(super) fn propose(session: &mut Session<'_>, plan: &Plan, files: &Files) {
    let Some((path, ini)) = files_of(plan) else { return };
    let asked = asked(plan, files);
    let Ok(found) = of(&path, ini.as_deref(), plan, &asked) else { return };
    if found.missing.is_empty() {
        return;
    }
    let missing: Vec<&str> = found.missing.iter().map(String::as_str).collect();
    let names: BTreeSet<&str> = asked.names().chain(missing.iter().copied()).collect();
    let names: Vec<&str> = names.into_iter().collect();
    session.stand_at(&path, 0);
    let with = if plan.options.simulate { "" } else { " --virtual" };
    session.warn_at(&format!(
        "not there: {}; pins in their place let the rest of the machine be tried:{with} --stub {}",
        missing.join(", "),
        names.join(",")
    ));
    let folder = Path::new(LINUXCNC_FOLDER);
    let modules: Vec<&str> =
        missing.iter().filter(|name| is_of_linuxcnc(name, folder)).copied().collect();
    if !modules.is_empty() {
        session.warn_at(&format!(
            "{}: of LinuxCNC's package linuxcnc-uspace; --linuxcnc-modules loads its modules",
            modules.join(", ")
        ));
    }
}

/// Returns whether LinuxCNC's package has a component; where it is not installed, whether it is one of Mesa's cards.
fn is_of_linuxcnc(name: &str, folder: &Path) -> bool {
    name == "hostmot2" || name.starts_with("hm2_") || folder.join(format!("{name}.so")).is_file()
}

fn of(path: &str, ini: Option<&str>, plan: &Plan, asked: &Asked) -> Result<StandIns, Error> {
    let files = [path.to_owned()];
    // Modules in C say a second time what they say when they are loaded.
    with_default(NoSubscriber::new(), || {
        let plugins = plan.options.path.clone();
        let mut dry_run = DryRun::replacing(&files, ini, plugins, Some(asked))?;
        Ok(dry_run.stand_ins(asked))
    })
}

/// Returns the machine's script or INI file, and the INI file of a script. What is no file can be read only once.
fn files_of(plan: &Plan) -> Option<(String, Option<String>)> {
    let files = match &plan.script {
        Script::Ini(path) => (path.clone(), None),
        Script::Hal(path) => (path.clone(), plan.ini.clone()),
        Script::Tcl(_) | Script::Terminal | Script::Nothing => return None,
    };
    Path::new(&files.0).is_file().then_some(files)
}

fn asked(plan: &Plan, files: &Files) -> Asked {
    let entries = files.ini.iter().flat_map(|ini| ini.all("HAL", "STUB"));
    let texts =
        entries.map(|entry| entry.value.as_str()).chain(plan.stubs.iter().map(String::as_str));
    let shown = files.ini.as_ref().is_some_and(|ini| display::is_shown(plan, ini));
    let is_machine = matches!(plan.script, Script::Ini(_));
    Asked::of(texts, plan.options.simulate, plan.headless || is_machine && !shown)
}

/// Returns whether the machine's files name programs of hardware, or pins of a screen that is not shown.
fn needs(plan: &Plan, files: &Files, path: &str, asked: &Asked) -> bool {
    let scripts = match (&plan.script, &files.ini) {
        (Script::Hal(_), _) => {
            return plan.options.simulate
                && names(&files.script, Path::new(path), &mut BTreeSet::new());
        }
        (_, Some(ini)) => scripts(ini, path),
        _ => return false,
    };
    let postgui =
        files.ini.as_ref().is_some_and(|ini| ini.all("HAL", "POSTGUI_HALFILE").next().is_some());
    let named = scripts.iter().any(|(path, text)| names(text, path, &mut BTreeSet::new()));
    asked.is_headless() && postgui || (plan.options.simulate || plan.headless) && named
}

/// Returns whether a text, or a file that it sources, names such a program. `seen` has the files that were looked at.
fn names(text: &[u8], path: &Path, seen: &mut BTreeSet<PathBuf>) -> bool {
    if standin::is_named_in(text) {
        return true;
    }
    let lines = String::from_utf8_lossy(text).into_owned();
    let sourced = lines.lines().filter_map(|line| line.trim().strip_prefix("source "));
    sourced.into_iter().any(|file| {
        let here = path.parent().unwrap_or_else(|| Path::new(""));
        let file = hal_ini::beside(here, file);
        seen.len() < MAX_FILES
            && file.is_file()
            && seen.insert(file.clone())
            && hal_ini::file::whole(&file).is_ok_and(|text| names(&text, &file, seen))
    })
}

/// Returns the HAL files of a machine with their texts.
fn scripts(ini: &Ini, path: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folders = Folders::of(Path::new(path));
    let entries = ini.all("HAL", "HALFILE").chain(ini.all("HAL", "POSTGUI_HALFILE"));
    let found = entries.filter_map(|entry| folders.find(entry.value.split_whitespace().next()?));
    found.filter_map(|(_, path)| Some((path.clone(), hal_ini::file::whole(&path).ok()?))).collect()
}
