//! The program halpanel: a machine in the browser.
#![forbid(unsafe_code)]

use halpanel::Options;
use std::{
    env,
    io::Write as _,
    os::unix::process::CommandExt as _,
    process::{Command, ExitCode},
};

/// Settings of the C library's memory: one arena, which gives back what is free at its end from 64 kB on. With those that it
/// chooses itself, the work of a thousand requests that have gone keeps half of the panel's memory.
const MEMORY: [(&str, &str); 2] = [("MALLOC_ARENA_MAX", "1"), ("MALLOC_TRIM_THRESHOLD_", "65536")];

/// Begins this program again with [`MEMORY`], which a process reads when it begins, unless it has begun so.
fn begin_again() {
    if MEMORY.iter().all(|(name, _)| env::var_os(name).is_some()) {
        return;
    }
    if let Ok(own) = env::current_exe() {
        // If the system refuses, the panel works with more memory.
        drop(Command::new(own).args(env::args_os().skip(1)).envs(MEMORY).exec());
    }
}

fn main() -> ExitCode {
    begin_again();
    hal_output::program(|_| match halpanel::run(&Options::given()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            // Without standard error there is nowhere else to say it.
            drop(writeln!(std::io::stderr(), "halpanel: {text}"));
            ExitCode::FAILURE
        }
    })
}
