//! All requested tests, several at a time.

use super::{NAME, Wanted, failure::Failure, junit, outcome::Outcome, picture, process, report};
use crate::{Terminal, ini::plain};
use std::{
    fs,
    path::{Path, PathBuf},
    sync::{
        atomic::{AtomicUsize, Ordering},
        mpsc,
    },
};

/// Runs the requested tests. Returns the exit status of the program.
pub(super) fn main(wanted: &Wanted, terminal: &mut dyn Terminal) -> Result<u8, Failure> {
    if wanted.paths.is_empty() {
        return Err(asked("which tests? Name a folder or a file"));
    }
    let mut files = Vec::new();
    for path in &wanted.paths {
        found(Path::new(path), &mut files).map_err(|e| asked(&format!("{path}: {}", plain(&e))))?;
    }
    let all = files.len();
    if let Some(part) = &wanted.filter {
        files.retain(|f| f.display().to_string().contains(part));
    }
    if files.is_empty() {
        return Err(asked(&match &wanted.filter {
            Some(part) if all > 0 => format!("none of {all} tests has '{part}' in its name"),
            _ => format!("no tests in {}", wanted.paths.join(", ")),
        }));
    }
    if wanted.list {
        for file in &files {
            terminal.out(&format!("{}\n", file.display()))?;
        }
        return Ok(0);
    }
    if let Some(folder) = &wanted.record {
        fs::create_dir_all(folder).map_err(|e| Failure::file(folder, &e))?;
    }
    let outcomes = run(wanted, &files, terminal)?;
    if let Some(path) = &wanted.junit {
        let text = junit::write(&outcomes)
            .map_err(|e| Failure::Unwritten(format!("{}: {e}", path.display())))?;
        hal_output::write(path, text.as_bytes()).map_err(|e| Failure::file(path, &e))?;
    }
    if !wanted.json {
        terminal.out(&report::summary(&outcomes))?;
    }
    Ok(u8::from(outcomes.iter().any(|o| !o.passed())))
}

fn asked(text: &str) -> Failure {
    Failure::Asked(format!("{NAME}: {text}"))
}

/// Runs the tests. Reports each test as soon as all tests before it are done.
fn run(
    wanted: &Wanted,
    files: &[PathBuf],
    terminal: &mut dyn Terminal,
) -> Result<Vec<Outcome>, Failure> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let mut done: Vec<Option<Outcome>> = files.iter().map(|_| None).collect();
    let mut outcomes = Vec::new();
    std::thread::scope(|scope| {
        for _ in 0..wanted.jobs.min(files.len()) {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                loop {
                    let n = next.fetch_add(1, Ordering::Relaxed);
                    let Some(file) = files.get(n) else { break };
                    let recording = wanted.record.as_ref().map(|f| f.join(recording(file)));
                    let options = process::Options {
                        patience_ns: wanted.patience_ns,
                        recording,
                        ..process::Options::default()
                    };
                    if sender.send((n, process::run_with(file, &options))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for (n, outcome) in receiver {
            if let Some(place) = done.get_mut(n) {
                *place = Some(outcome);
            }
            while let Some(outcome) = done.get_mut(outcomes.len()).and_then(Option::take) {
                outcomes.push(told(wanted, outcome, terminal)?);
            }
        }
        Ok(())
    })
    .map(|()| outcomes)
}

/// Reports a test, and accepts its waveforms if `--accept` was given.
fn told(
    wanted: &Wanted,
    mut outcome: Outcome,
    terminal: &mut dyn Terminal,
) -> Result<Outcome, Failure> {
    let accepted = if wanted.accept { picture::accept(&mut outcome)? } else { Vec::new() };
    if wanted.json {
        let text =
            serde_json::to_string(&outcome).map_err(|e| Failure::Unwritten(e.to_string()))?;
        terminal.out(&format!("{text}\n"))?;
        return Ok(outcome);
    }
    terminal.out(&format!("{outcome}\n"))?;
    for path in accepted {
        terminal.out(&format!("  accepted: {}\n", path.display()))?;
    }
    if wanted.accept && !outcome.passed() && outcome.pictures.iter().any(|p| !p.same) {
        terminal
            .out("  its waveforms are not accepted: the test also fails for another reason\n")?;
    }
    Ok(outcome)
}

/// Returns the file name for the recording of a test.
fn recording(file: &Path) -> String {
    let words: Vec<String> = file
        .with_extension("")
        .components()
        .filter_map(|c| match c {
            std::path::Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
            _ => None,
        })
        .collect();
    words.join("-") + ".vcd"
}

/// Collects the tests in a folder and below it, sorted by name, or the one file with this name.
fn found(path: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if !path.is_dir() {
        fs::metadata(path)?;
        files.push(path.to_owned());
        return Ok(());
    }
    let mut entries: Vec<PathBuf> =
        fs::read_dir(path)?.flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for entry in entries {
        let hidden = entry.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
        let link = entry.is_symlink();
        if entry.is_dir() && !hidden && !link {
            found(&entry, files)?;
        } else if entry.extension().is_some_and(|e| e == "toml") && !hidden {
            files.push(entry);
        }
    }
    Ok(())
}
