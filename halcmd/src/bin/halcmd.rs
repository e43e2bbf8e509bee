//! The program halcmd: gives commands to a running instance.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::programs::halcmd::main)
}
