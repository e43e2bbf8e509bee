//! Prints the records that a sampler component takes.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::sampler::main)
}
