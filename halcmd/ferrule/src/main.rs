//! The front command of Ferrule. Each of its commands starts the programs that do the work, or looks at the computer:
//! what it starts can be started without it.
#![forbid(unsafe_code)]

mod beside;
mod commission;
mod demo;
mod docs;
mod doctor;
mod failure;
mod options;
mod report;
mod restore;
mod start;
mod trial;

use clap::Parser as _;
use failure::Failure;
use options::{Ferrule, Task};
use std::{io::Write as _, process::ExitCode};

fn main() -> ExitCode {
    hal_output::program(|_| match run(&Ferrule::parse().task) {
        Ok(code) => code,
        Err(error) => {
            // Without standard error there is nowhere else to say it.
            drop(writeln!(std::io::stderr(), "ferrule: {error}"));
            ExitCode::FAILURE
        }
    })
}

fn run(task: &Task) -> Result<ExitCode, Failure> {
    match task {
        Task::Start(given) => start::start(given),
        Task::Demo(given) => demo::demo(given),
        Task::New { words } => beside::instead("halsetup", words),
        Task::Status { words } => {
            let words: Vec<String> = [vec!["status".to_owned()], words.clone()].concat();
            beside::instead("halcmd", &words)
        }
        Task::Stop { instance } => {
            let named = instance.iter().flat_map(|name| ["--instance".to_owned(), name.clone()]);
            beside::instead(
                "halrun",
                &["-U".to_owned()].into_iter().chain(named).collect::<Vec<_>>(),
            )
        }
        Task::Try(given) => trial::trial(given),
        Task::Commission(given) => commission::commission(given),
        Task::Doctor(given) => doctor::doctor(given),
        Task::Docs(given) => docs::docs(given),
        Task::Report(given) => report::report(given),
        Task::Restore(given) => restore::restore(given),
    }
}
