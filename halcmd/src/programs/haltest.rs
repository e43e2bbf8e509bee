//! The program haltest: tests of machines, written as text beside their scripts.
//!
//! A test is a TOML file. It names a machine, the steps that are applied to it and their times, and
//! the results that are expected. It runs in virtual time, in a process and an instance of its own,
//! and every run gives the same result. `halcmd/README.md` describes the format.
//!
//! In Rust, [`run`] returns the [`Outcome`] of one file, with its waveforms as text for a test to
//! compare:
//!
//! ```no_run
//! let outcome = halcmd::haltest::run("configs/printer/tests/reversal.toml");
//! assert!(outcome.passed(), "{outcome}");
//! println!("{}", outcome.drawing("turn").unwrap_or_default());
//! ```

mod bench;
mod compare;
mod condition;
mod evaluate;
mod expectation;
mod failure;
mod file;
mod inject;
mod instant;
mod junit;
mod list;
mod one;
mod outcome;
mod picture;
mod process;
mod pulses;
mod report;
mod run;
mod settings;
mod source;
mod stage;
mod step;
mod test;
mod watch;

use failure::Failure;

pub use outcome::{Complaint, Outcome, Picture, Spot};
pub use process::{Options, run, run_with};

use crate::{
    Error, Stdio, Terminal, nanoseconds,
    programs::options::{Opt, mixed, plain, program_usage},
    terminal::print_error,
};
use std::{path::PathBuf, process::ExitCode};

const NAME: &str = "haltest";

/// Default limit on the wall-clock time of a test.
const TIMEOUT_NS: u64 = 60_000_000_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Jobs,
    Filter,
    List,
    Accept,
    Junit,
    Json,
    Record,
    Timeout,
    One,
    To,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        long: Some("jobs"),
        help: "run N tests at once; else one for each processor",
        ..Opt::short_with(Id::Jobs, 'j', "N")
    },
    with("filter", Id::Filter, Some("TEXT"), "only tests whose name has TEXT in it"),
    with("list", Id::List, None, "print which tests there are"),
    with("accept", Id::Accept, None, "accept the present waveforms of tests that otherwise pass"),
    with("junit", Id::Junit, Some("FILE"), "write the results as JUnit XML"),
    with("json", Id::Json, None, "print the result of each test as an object"),
    with(
        "record",
        Id::Record,
        Some("FOLDER"),
        "keep the recording of each test there, as NAME.vcd",
    ),
    with("timeout", Id::Timeout, Some("TIME"), "abort a test after TIME of wall-clock time (60s)"),
    Opt { help: "print this", long: Some("help"), ..Opt::flag(Id::Help, 'h') },
];

/// Returns the options for completion.
pub(crate) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Undocumented options, with which haltest starts the process of a single test.
const HIDDEN: &[Opt<Id>] =
    &[with("one", Id::One, Some("FILE"), ""), with("to", Id::To, Some("FOLDER"), "")];

const fn with(
    name: &'static str,
    id: Id,
    value: Option<&'static str>,
    help: &'static str,
) -> Opt<Id> {
    Opt { id, short: None, long: Some(name), value, variable: None, help }
}

/// Parsed command line.
struct Wanted {
    jobs: usize,
    filter: Option<String>,
    list: bool,
    accept: bool,
    junit: Option<PathBuf>,
    json: bool,
    record: Option<PathBuf>,
    patience_ns: u64,
    paths: Vec<String>,
}

/// Runs the program with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    match run_program(words) {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            print_error(&match failure {
                Failure::Asked(text) => format!("{text}\n\nFor usage try: {NAME} -h\n"),
                Failure::Unwritten(text) => format!("{NAME}: {text}\n"),
            });
            ExitCode::from(2)
        }
    }
}

fn run_program(words: &[String]) -> Result<u8, Failure> {
    let mut terminal = Stdio;
    let table = [OPTIONS, HIDDEN].concat();
    let (given, paths) = mixed(NAME, &table, words).map_err(|e| Failure::Asked(e.whole()))?;
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.clone();
    if given.iter().any(|(id, _)| *id == Id::Help) {
        terminal.out(&help())?;
        return Ok(0);
    }
    if let (Some(file), Some(folder)) = (value(Id::One), value(Id::To)) {
        one::main(&file, folder.as_ref())?;
        return Ok(0);
    }
    let wanted = wanted(&given, paths).map_err(|e| Failure::Asked(e.whole()))?;
    list::main(&wanted, &mut terminal)
}

fn wanted(given: &[(Id, Option<String>)], paths: Vec<String>) -> Result<Wanted, Error> {
    let has = |wanted| given.iter().any(|(id, _)| *id == wanted);
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.clone();
    let bad = |option: &str, value: &str, why: &str| Error::OptionValue {
        program: NAME,
        option: option.into(),
        value: value.into(),
        why: why.into(),
    };
    let jobs = match value(Id::Jobs) {
        Some(text) => text
            .parse()
            .ok()
            .filter(|n| *n > 0)
            .ok_or_else(|| bad("-j", &text, "it is a number, 1 or more"))?,
        None => std::thread::available_parallelism().map_or(1, usize::from),
    };
    let patience_ns = match value(Id::Timeout) {
        Some(text) => nanoseconds(&text)
            .map_err(|_| bad("--timeout", &text, "it is a number and ms or s, such as 60s"))?,
        None => TIMEOUT_NS,
    };
    Ok(Wanted {
        jobs,
        filter: value(Id::Filter),
        list: has(Id::List),
        accept: has(Id::Accept),
        junit: value(Id::Junit).map(PathBuf::from),
        json: has(Id::Json),
        record: value(Id::Record).map(PathBuf::from),
        patience_ns,
        paths,
    })
}

fn help() -> String {
    format!(
        "\nUsage:   {NAME} [options] FOLDER|FILE...\n\n\
         Runs the tests of machines: every TOML file in a folder and below it, or those named. Each\n\
         runs in virtual time, in an instance of its own. The status is 0 if all is as it should be,\n\
         1 if something is not, 2 if nothing could be tested.\n\noptions:\n{}",
        program_usage(OPTIONS)
    )
}
