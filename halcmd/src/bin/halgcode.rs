//! Checks, prints, draws and tidies G-code without a machine.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::programs::halgcode::main)
}
