//! The folder of a machine: its files, checked before they are kept.

use super::{
    answers::Answers,
    clean::{allowed, notes},
    proof, timing, wiring, write,
};
use crate::check;
use std::{fs, io, path::Path};

/// Makes the machine's folder. It is removed again unless the machine is clean.
pub(super) fn make(answers: &Answers, text: &str, folder: &Path) -> Result<String, String> {
    let name = &answers.name;
    let latency = answers.latency;
    let timing = timing::timing(answers).map_err(|(joint, possible)| {
        format!("joint {joint}: too fast for a jitter of {latency} ns; a velocity of {possible:.3} is possible")
    })?;
    let target = folder.join(name);
    let tests =
        proof::tests(answers).into_iter().map(|(name, text)| (format!("tests/{name}"), text));
    let mut files = vec![
        (format!("{name}.ini"), write::ini(answers, &timing)),
        (format!("{name}.hal"), wiring::hal(answers, &timing)),
        ("custom.hal".to_owned(), "# Wiring of your own, after the machine's.\n".to_owned()),
        ("tool.tbl".to_owned(), "T1 P1 ;the first tool\n".to_owned()),
        (format!("{name}.setup"), text.to_owned()),
    ];
    files.extend(tests);
    let is_new = !folder.exists();
    fs::create_dir_all(folder).map_err(|e| told(folder, &e))?;
    fs::create_dir(&target).map_err(|e| match e.kind() {
        io::ErrorKind::AlreadyExists => {
            format!("{}: is there already; another name, or --output", target.display())
        }
        _ => format!("{}: {}", target.display(), hal_output::reason(&e)),
    })?;
    match settle(answers, &target, files) {
        Ok(()) => {
            let (base, shortest) = (timing.base, timing.shortest);
            let (ini, target) = (target.join(format!("{name}.ini")), target.display().to_string());
            Ok(format!(
                "base period {base} ns; a jitter of {latency} ns allows {shortest} ns\n\
                 {0}: written, and checked without a finding\n\
                 test it: haltest {target}\ntry it: halrun --virtual --for 1s {0}\n",
                ini.display()
            ))
        }
        Err(error) => {
            // What was begun is of no use; the error to tell is the first one.
            drop(fs::remove_dir_all(&target));
            if is_new {
                drop(fs::remove_dir(folder));
            }
            Err(error)
        }
    }
}

/// Writes the files, and writes them again with the reasons of notes that ask for nothing. What is found then is an error.
fn settle(answers: &Answers, target: &Path, files: Vec<(String, String)>) -> Result<(), String> {
    let ini = target.join(format!("{}.ini", answers.name));
    fs::create_dir(target.join("tests")).map_err(|e| told(target, &e))?;
    write_all(target, &files)?;
    let files = allowed(answers, &notes(&ini)?, target, &files);
    write_all(target, &files)?;
    let checked = notes(&ini)?;
    if checked.findings.is_empty() {
        return Ok(());
    }
    let findings = check::text(&checked).replace(&format!("{}/", target.display()), "");
    Err(format!("the answers make no clean machine; nothing was kept:\n{findings}"))
}

fn write_all(target: &Path, files: &[(String, String)]) -> Result<(), String> {
    for (file, text) in files {
        let path = target.join(file);
        hal_output::write(&path, text.as_bytes()).map_err(|e| told(&path, &e))?;
    }
    Ok(())
}

fn told(path: &Path, error: &io::Error) -> String {
    format!("{}: {}", path.display(), hal_output::reason(error))
}
