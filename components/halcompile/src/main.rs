//! The program `halcompile`.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program speaks")]

use clap::Parser;
use halcompile::command::{Args, run};
use std::process::ExitCode;

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(said) => {
            print!("{}", said.out);
            eprint!("{}", said.doubts);
            ExitCode::SUCCESS
        }
        Err(e) => {
            eprintln!("{e}");
            ExitCode::FAILURE
        }
    }
}
