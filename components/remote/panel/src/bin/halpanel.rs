//! The program halpanel: a machine in the browser.
#![forbid(unsafe_code)]

use halpanel::Options;
use std::{io::Write as _, process::ExitCode};

fn main() -> ExitCode {
    hal_output::program(|_| match halpanel::run(&Options::given()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            // Without standard error there is nowhere else to say it.
            drop(writeln!(std::io::stderr(), "halpanel: {text}"));
            ExitCode::FAILURE
        }
    })
}
