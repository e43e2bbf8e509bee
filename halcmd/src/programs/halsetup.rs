//! The program halsetup: writes a machine's INI and HAL files from questions in the terminal or from a TOML file of
//! answers, and keeps them if they are clean.

mod answers;
mod questions;
mod timing;
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
    Help,
}

const OPTIONS: &[Opt<Flag>] = &[
    Opt {
        help: "where the machine's folder is made; here if none is given",
        long: Some("output"),
        ..Opt::short_with(Flag::Output, 'o', "FOLDER")
    },
    Opt { help: "print this", long: Some("help"), ..Opt::flag(Flag::Help, 'h') },
];

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
                     it asks in the terminal, and keeps the answers beside the machine.\n\noptions:\n";
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
    let written = make(&answers, &text, &folder)?;
    Stdio.out(&written)?;
    Ok(())
}

fn text_of(file: &str) -> Result<String, String> {
    let opened = fs::File::open(file).map_err(|e| format!("{file}: {}", hal_output::reason(&e)))?;
    let mut bytes = Vec::new();
    opened
        .take(MAX_ANSWERS + 1)
        .read_to_end(&mut bytes)
        .map_err(|e| format!("{file}: {}", hal_output::reason(&e)))?;
    if bytes.len() as u64 > MAX_ANSWERS {
        return Err(format!("{file}: answers have at most {MAX_ANSWERS} bytes"));
    }
    String::from_utf8(bytes).map_err(|_| format!("{file}: answers are text in UTF-8"))
}

/// Asks in the terminal.
fn asked() -> Result<String, String> {
    let stdin = io::stdin();
    let mut ask = |prompt: &str| {
        Stdio.out(prompt)?;
        let mut line = String::new();
        match stdin.lock().take(4096).read_line(&mut line) {
            Ok(0) => Ok(None),
            Ok(_) => Ok(Some(line)),
            Err(e) => Err(hal_output::reason(&e)),
        }
    };
    questions(&mut Dialog { ask: &mut ask })
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
