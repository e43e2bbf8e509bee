//! Samples any pin, draws what was sampled, and shows it in the terminal.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::scope::main)
}
