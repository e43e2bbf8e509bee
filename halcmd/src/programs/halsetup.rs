//! The program halsetup: writes a machine's INI and HAL files from questions in the terminal or from a TOML file of
//! answers, and keeps them if they are clean.

mod answers;
mod lines;
mod questions;
mod search;
mod timing;
mod trial;
mod write;

use crate::{
    Stdio, Terminal,
    check::{self, Checked, check, status},
    programs::{
        halrun::folders::plugin_path,
        options::{Opt, mixed, plain, program_usage},
        profile::Profile,
    },
    terminal::ended,
};
use answers::{Answers, Wrong};
use hal_protocol::Level;
use questions::{Dialog, questions};
use std::{
    fs,
    io::{self, BufRead as _, Read as _},
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Longest file of answers, in bytes.
const MAX_ANSWERS: u64 = 1 << 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Flag {
    Output,
    Test,
    Amplitude,
    VelocityStep,
    AccelerationStep,
    Simulate,
    Virtual,
    Help,
}

const OPTIONS: &[Opt<Flag>] = &[
    Opt {
        help: "where the machine's folder is made; here if none is given",
        long: Some("output"),
        ..Opt::short_with(Flag::Output, 'o', "FOLDER")
    },
    with(Flag::Test, "test", "AXIS", "search the velocity and acceleration that an axis bears"),
    with(Flag::Amplitude, "amplitude", "LENGTH", "test: way to each side (0.45 of the travel)"),
    with(Flag::VelocityStep, "velocity-step", "V", "test: increment (a tenth of the velocity)"),
    with(
        Flag::AccelerationStep,
        "acceleration-step",
        "A",
        "test: increment (a tenth of the answer)",
    ),
    with(Flag::Simulate, "simulate", "V,A", "test: a simulated motor that stalls from V and A on"),
    Opt {
        value: None,
        ..with(Flag::Virtual, "virtual", "", "test: on the virtual clock, a person judges")
    },
    Opt { help: "print this", long: Some("help"), ..Opt::flag(Flag::Help, 'h') },
];

const fn with(id: Flag, name: &'static str, value: &'static str, help: &'static str) -> Opt<Flag> {
    Opt { id, short: None, long: Some(name), value: Some(value), variable: None, help }
}

/// Returns the options for completion.
pub(crate) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs the program with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    ended(run(words).map_err(|text| format!("halsetup: {text}")))
}

fn run(words: &[String]) -> Result<(), String> {
    let (given, files) = mixed("halsetup", OPTIONS, words).map_err(|e| e.to_string())?;
    if given.iter().any(|(id, _)| *id == Flag::Help) {
        let about = "Usage: halsetup [options] [ANSWERS]\n\n\
                     Writes a machine's INI and HAL files into a new folder with its name. Without a file of answers\n\
                     it asks in the terminal, and keeps the answers beside the machine.\n\n\
                     With --test it makes no files: it runs an axis of the answers back and forth, harder each time, and\n\
                     asks whether the axis stands on its mark again. The machine moves: keep a hand on the e-stop.\n\noptions:\n";
        Stdio.out(&format!("{about}{}", program_usage(OPTIONS)))?;
        return Ok(());
    }
    let output = given.iter().rev().find(|(id, _)| *id == Flag::Output);
    let folder = PathBuf::from(
        output.and_then(|(_, value)| value.clone()).unwrap_or_else(|| ".".to_owned()),
    );
    let (name, text) = match files.as_slice() {
        [] => ("answers".to_owned(), asked()?),
        [file] => (file.clone(), text_of(file)?),
        _ => return Err("one file of answers at most".to_owned()),
    };
    let answers = answers::read(&text).map_err(|list| places(&name, &text, &list))?;
    if let Some(search) = asked_search(&given)? {
        Stdio.out(&trial::test(&answers, &search, &mut line)?)?;
        return Ok(());
    }
    let written = make(&answers, &text, &folder)?;
    Stdio.out(&written)?;
    Ok(())
}

/// Returns the search that the options ask for.
fn asked_search(given: &[(Flag, Option<String>)]) -> Result<Option<trial::Search>, String> {
    let value = |flag| given.iter().rev().find(|(id, _)| *id == flag).map(|(_, v)| v.clone());
    let text = |flag| value(flag).flatten();
    let number = |flag, name: &str| match text(flag) {
        None => Ok(None),
        Some(text) => trial::positive(&text)
            .map(Some)
            .ok_or_else(|| format!("--{name} '{text}': a number above 0")),
    };
    let search = trial::Search {
        axis: text(Flag::Test).unwrap_or_default(),
        amplitude: number(Flag::Amplitude, "amplitude")?,
        velocity_step: number(Flag::VelocityStep, "velocity-step")?,
        acceleration_step: number(Flag::AccelerationStep, "acceleration-step")?,
        stall: match text(Flag::Simulate) {
            None => None,
            Some(text) => Some(trial::pair(&text).ok_or_else(|| {
                format!("--simulate '{text}': VELOCITY,ACCELERATION, two numbers above 0")
            })?),
        },
        is_virtual: value(Flag::Virtual).is_some(),
    };
    if value(Flag::Test).is_some() {
        return Ok(Some(search));
    }
    if search == trial::Search::default() {
        return Ok(None);
    }
    Err("--amplitude, the increments, --simulate and --virtual are for --test".to_owned())
}

fn text_of(file: &str) -> Result<String, String> {
    let bytes = hal_ini::file::contents(Path::new(file), MAX_ANSWERS)
        .map_err(|e| format!("{file}: {}", hal_output::reason(&e)))?
        .ok_or_else(|| format!("{file}: answers have at most {MAX_ANSWERS} bytes"))?;
    String::from_utf8(bytes).map_err(|_| format!("{file}: answers are text in UTF-8"))
}

/// Asks in the terminal.
fn asked() -> Result<String, String> {
    questions(&mut Dialog { ask: &mut line })
}

/// Asks a person for a line; `None` at the end of the input.
fn line(prompt: &str) -> Result<Option<String>, String> {
    Stdio.out(prompt)?;
    let mut line = String::new();
    match io::stdin().lock().take(4096).read_line(&mut line) {
        Ok(0) => Ok(None),
        Ok(_) => Ok(Some(line)),
        Err(e) => Err(hal_output::reason(&e)),
    }
}

/// Returns all that is wrong, each with its line.
fn places(file: &str, text: &str, list: &[Wrong]) -> String {
    let line = |at: usize| text.get(..at).map_or(1, |before| before.matches('\n').count() + 1);
    let each: Vec<String> =
        list.iter().map(|w| format!("{file}:{}: {}", line(w.at), w.text)).collect();
    each.join("\nhalsetup: ")
}

/// Makes the machine's folder. It is removed again unless the machine is clean.
fn make(answers: &Answers, text: &str, folder: &Path) -> Result<String, String> {
    let name = answers.name.get_ref();
    let latency = answers.latency.get_ref();
    let timing = timing::timing(answers).map_err(|(joint, possible)| {
        format!("joint {joint}: too fast for a jitter of {latency} ns; a velocity of {possible:.3} is possible")
    })?;
    let target = folder.join(name);
    let files = [
        (format!("{name}.ini"), write::ini(answers, &timing)),
        (format!("{name}.hal"), write::hal(answers, &timing)),
        ("custom.hal".to_owned(), "# Wiring of your own, after the machine's.\n".to_owned()),
        ("tool.tbl".to_owned(), "T1 P1 ;the first tool\n".to_owned()),
        (format!("{name}.setup"), text.to_owned()),
    ];
    fs::create_dir(&target).map_err(|e| match e.kind() {
        io::ErrorKind::AlreadyExists => {
            format!("{}: is there already; another name, or --output", target.display())
        }
        _ => format!("{}: {}", target.display(), hal_output::reason(&e)),
    })?;
    match settle(&target, &files, name) {
        Ok(told) => {
            let (base, shortest) = (timing.base, timing.shortest);
            let period =
                format!("base period {base} ns; a jitter of {latency} ns allows {shortest} ns");
            Ok(format!("{period}\n{told}"))
        }
        Err(error) => {
            // What was begun is of no use; the error to tell is the first one.
            drop(fs::remove_dir_all(&target));
            Err(error)
        }
    }
}

fn settle(target: &Path, files: &[(String, String)], name: &str) -> Result<String, String> {
    let told =
        |path: &Path, e: &io::Error| format!("{}: {}", path.display(), hal_output::reason(e));
    for (file, text) in files {
        let path = target.join(file);
        hal_output::write(&path, text.as_bytes()).map_err(|e| told(&path, &e))?;
    }
    let ini = target.join(format!("{name}.ini"));
    let profile = Profile::of_environment().map_err(|e| e.to_string())?;
    let plugins = plugin_path(&|name| profile.system(name));
    let checked = check(&[ini.to_string_lossy().into_owned()], None, plugins);
    if status(&checked.findings) > 0 {
        let serious = checked.findings.into_iter().filter(|f| f.level > Level::Note).collect();
        let findings = check::text(&Checked { findings: serious, ..checked });
        let findings = findings.replace(&format!("{}/", target.display()), "");
        return Err(format!("the answers make no clean machine; nothing was kept:\n{findings}"));
    }
    Ok(format!(
        "{0}: written, and checked without an error or a warning\ntry it: halrun --virtual --for 1s {0}\n",
        ini.display()
    ))
}
