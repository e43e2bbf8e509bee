//! Filters: programs of `[FILTER]` that turn other files into G-code.

use crate::{Stdio, Terminal, terminal::print_error};
use hal_gcode::Text;
use hal_job::{machine::Machine, world};
use std::{
    io::{BufRead, BufReader, Read},
    path::Path,
    process::{Command, Stdio as Pipe},
    sync::Arc,
};

/// The largest program that a filter may write.
const MAX_BYTES: u64 = 1 << 30;
/// The mark of a filter's progress on standard error, before a number of per cent.
const PROGRESS: &str = "FILTER_PROGRESS=";

/// Reads a program, through a filter if the INI file has one for its ending.
///
/// # Errors
/// The file cannot be read, or the filter fails.
pub(super) fn load(path: &Path, machine: &Machine) -> Result<Text, String> {
    match command(path, machine) {
        None => world::program(path),
        Some(words) => filtered(path, &words, machine),
    }
}

/// Returns the words of the filter's command.
fn command(path: &Path, machine: &Machine) -> Option<Vec<String>> {
    let ini = machine.ini.as_ref()?;
    let ending = path.extension()?.to_str()?;
    let listed = ini.all("FILTER", "PROGRAM_EXTENSION").any(|entry| {
        let endings = entry.value.split(|c: char| c == ',' || c.is_whitespace());
        endings.filter_map(|e| e.strip_prefix('.')).any(|e| e == ending)
    });
    let words = ini.get("FILTER", ending).filter(|_| listed)?;
    let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
    (!words.is_empty()).then_some(words)
}

fn filtered(path: &Path, words: &[String], machine: &Machine) -> Result<Text, String> {
    let (program, arguments) = words.split_first().ok_or("an empty filter")?;
    let shown = |reason: &str| format!("[FILTER] {program} {}: {reason}", path.display());
    // A program of the machine's own folder needs no path.
    let beside = machine.folder.join(program);
    if machine.places.as_ref().is_some_and(|places| places.is_open_to_others(&beside)) {
        return Err(shown("in a folder of uploads or output, where nothing is run"));
    }
    let mut child =
        Command::new(if beside.is_file() { beside.as_os_str() } else { program.as_ref() })
            .args(arguments)
            .arg(path)
            .stdin(Pipe::null())
            .stdout(Pipe::piped())
            .stderr(Pipe::piped())
            .spawn()
            .map_err(|e| shown(&hal_output::reason(&e)))?;
    let errors = child.stderr.take();
    let listener = std::thread::spawn(move || errors.map(follow).unwrap_or_default());
    let mut text = Vec::new();
    if let Some(output) = child.stdout.take() {
        let read = output.take(MAX_BYTES + 1).read_to_end(&mut text);
        read.map_err(|e| shown(&hal_output::reason(&e)))?;
    }
    if text.len() as u64 > MAX_BYTES {
        // It may have ended by itself meanwhile.
        child.kill().unwrap_or_default();
    }
    let status = child.wait().map_err(|e| shown(&hal_output::reason(&e)))?;
    listener.join().unwrap_or_default();
    if text.len() as u64 > MAX_BYTES {
        return Err(shown(&format!("writes more than {MAX_BYTES} bytes")));
    }
    if !status.success() {
        return Err(shown(&format!("ended with {status}")));
    }
    Ok(Arc::new(text))
}

/// Shows the progress of a filter to a person, and hands on the rest of its standard error.
fn follow(errors: std::process::ChildStderr) {
    let mut errors = BufReader::new(errors);
    let mut line = Vec::new();
    let mut shown = false;
    while let Ok(1..) = errors.read_until(b'\n', &mut line) {
        let text = String::from_utf8_lossy(&line);
        match text.trim().strip_prefix(PROGRESS).map(str::parse::<u32>) {
            Some(Ok(percent)) => {
                if Stdio.is_person() {
                    Stdio.err(&format!("\r{} %", percent.min(100)));
                    shown = true;
                }
            }
            _ => print_error(&text),
        }
        line.clear();
    }
    if shown {
        Stdio.err("\r      \r");
    }
}
