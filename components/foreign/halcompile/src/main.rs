//! The program `halcompile`.

use clap::Parser;
use halcompile::command::{Args, run};
use std::{io::Write, process::ExitCode};

/// Exit status for an invalid command line.
const USAGE: u8 = 2;

fn main() -> ExitCode {
    hal_output::program(|_| {
        ended().unwrap_or_else(|(text, status)| {
            if !hal_output::reader_is_gone() {
                report(&text);
            }
            ExitCode::from(status)
        })
    })
}

fn ended() -> Result<ExitCode, (String, u8)> {
    let unwritten = |e: hal_output::Unwritten| (format!("halcompile: {e}\n"), 1);
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(asked) if !asked.use_stderr() => {
            hal_output::print(&asked.render().to_string()).map_err(unwritten)?;
            return Ok(ExitCode::SUCCESS);
        }
        Err(wrong) => return Err((wrong.render().to_string(), USAGE)),
    };
    let said = run(&args).map_err(|e| (format!("{e}\n"), 1))?;
    report(&said.doubts);
    hal_output::print(&said.out).map_err(unwritten)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes to standard error, and ignores a failure, which could not be reported anywhere.
fn report(text: &str) {
    std::io::stderr().write_all(text.as_bytes()).unwrap_or_default();
}
