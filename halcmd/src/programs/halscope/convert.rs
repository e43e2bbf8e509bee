//! `halscope convert`: converts a trace to another file format.

use super::{plan::usage_of, unwritten};
use crate::{
    Stdio, Terminal,
    programs::options::{Opt, mixed, plain},
};
use hal_trace::{load, save};
use std::{path::Path, process::ExitCode};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Keep,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        help: "take what can be read of a file that is cut off or damaged",
        long: Some("keep"),
        ..Opt::flag(Id::Keep, 'k')
    },
    Opt { help: "print this", long: Some("help"), ..Opt::flag(Id::Help, 'h') },
];

const MORE: &str = "
The endings say what the files are: .vcd, .fst, .csv or .json. VCD and FST are also read from
simulators and logic analysers, CSV from whatever writes a table with times in its first column.
";

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs the command with these arguments.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, files) = mixed("halscope convert", OPTIONS, words).map_err(|e| e.to_string())?;
    let has = |id| given.iter().any(|(i, _)| *i == id);
    if has(Id::Help) {
        Stdio.out(&usage_of("convert [options] IN OUT", OPTIONS, MORE))?;
        return Ok(ExitCode::SUCCESS);
    }
    let [from, to] = &files[..] else {
        return Err("convert needs two files: IN OUT".to_owned());
    };
    let (reading, flaw) = load(Path::new(from)).map_err(|e| e.to_string())?;
    if let Some(flaw) = &flaw {
        let n = reading.trace.len();
        let s = if n == 1 { "" } else { "s" };
        if !has(Id::Keep) || reading.trace.channels().is_empty() {
            let hint = if reading.trace.is_empty() {
                String::new()
            } else {
                format!(
                    "\n{n} sample{s} can be read before that: halscope convert --keep takes them"
                )
            };
            return Err(format!("{flaw}{hint}"));
        }
        Stdio.err(&format!("halscope: {flaw}\nkept: {n} sample{s} before that\n"));
    }
    for note in &reading.notes {
        Stdio.err(&format!("halscope: {from}: {note}\n"));
    }
    save(Path::new(to), &reading.trace).map_err(|e| unwritten(&e))?;
    Ok(ExitCode::SUCCESS)
}
