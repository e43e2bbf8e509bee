//! The program halscope: captures values over time, and stores, draws and displays them.

mod capture;
mod convert;
mod figures;
mod live;
mod names;
mod plan;
mod plot;
mod view;

use crate::{
    Stdio, Terminal,
    language::{hint::nearest, units::nanoseconds},
    programs::options::{Opt, Subcommand},
    terminal::print_error,
};
use hal_trace::{FileError, Trace};
use std::{path::Path, process::ExitCode};

/// A command: name, arguments, description and function.
struct CommandRow {
    name: &'static str,
    words: &'static str,
    help: &'static str,
    options: fn() -> Vec<Opt<()>>,
    run: fn(&[String]) -> Result<ExitCode, String>,
}

const ROWS: &[CommandRow] = &[
    CommandRow {
        name: "capture",
        words: "[options] NAME...",
        help: "sample a machine at a trigger, into a file",
        options: plan::completable,
        run: capture::main,
    },
    CommandRow {
        name: "convert",
        words: "[options] IN OUT",
        help: "turn a file into one of another kind",
        options: convert::completable,
        run: convert::main,
    },
    CommandRow {
        name: "view",
        words: "FILE [CHANNEL...], or [options] NAME...",
        help: "look at a file or a machine in the terminal: zoom, cursors, measurements",
        options: plan::completable,
        run: view::main,
    },
    CommandRow {
        name: "plot",
        words: "[options] FILE [CHANNEL...]",
        help: "draw a file as SVG or PNG",
        options: plot::completable,
        run: plot::main,
    },
];

/// Returns the commands for completion.
pub(crate) fn subcommands() -> Vec<Subcommand> {
    let command = |row: &CommandRow| Subcommand {
        name: row.name,
        help: row.help,
        options: (row.options)(),
        takes_items: ["capture", "view"].contains(&row.name),
    };
    ROWS.iter().map(command).collect()
}

/// Runs the program with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    match run(words) {
        Ok(status) => status,
        Err(text) => {
            print_error(&format!("halscope: {text}\n"));
            ExitCode::FAILURE
        }
    }
}

fn run(words: &[String]) -> Result<ExitCode, String> {
    let (Some(name), rest) = (words.first(), words.get(1..).unwrap_or_default()) else {
        return Err(format!("which command?\n{}", usage()));
    };
    if ["-h", "--help", "help"].contains(&name.as_str()) {
        Stdio.out(&usage())?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(row) = ROWS.iter().find(|r| r.name == name) {
        return (row.run)(rest);
    }
    let near = nearest(name, ROWS.iter().map(|r| r.name));
    let near = near.map_or_else(String::new, |near| format!("; did you mean {near}?"));
    Err(format!("'{name}' is not a command{near}\n{}", usage()))
}

fn usage() -> String {
    let mut text = String::from("Usage:\n");
    for row in ROWS {
        text.push_str(&format!("  halscope {} {}\n      {}\n", row.name, row.words, row.help));
    }
    text.push_str("Each explains its options with -h. 'halscope --version' prints the version.\n");
    text
}

/// Reads a file as far as possible, and prints a message about a flaw in it.
fn load(path: &Path) -> Result<Trace, String> {
    let (reading, flaw) = hal_trace::load(path).map_err(|e| e.to_string())?;
    let notes = reading.notes.iter().map(|note| format!("{}: {note}\n", path.display()));
    Stdio.err(&notes.collect::<String>());
    if let Some(flaw) = flaw {
        if reading.trace.is_empty() {
            return Err(flaw.to_string());
        }
        let (n, text) = (reading.trace.len(), "what comes after them is not there");
        Stdio.err(&format!("halscope: {flaw}: {n} samples were read, {text}\n"));
    }
    Ok(reading.trace)
}

/// Returns the message for a file that could not be written. A pipe whose reader is gone ends the
/// program, as it does for standard output.
fn unwritten(error: &FileError) -> String {
    if matches!(error, FileError::ReaderGone(_)) {
        hal_output::lose_reader();
    }
    error.to_string()
}

/// Converts a time given as an option, such as `1.5ms` or `-20us`, to ticks of the trace.
fn time(trace: &Trace, text: &str) -> Result<i64, String> {
    let (is_negative, span) = text.strip_prefix('-').map_or((false, text), |t| (true, t));
    let ns = nanoseconds(span).ok().and_then(|ns| i64::try_from(ns).ok());
    let ns =
        ns.ok_or_else(|| format!("'{text}' is not a time; write a number and ns, us, ms or s"))?;
    Ok(trace.base().ticks(if is_negative { -ns } else { ns }))
}
