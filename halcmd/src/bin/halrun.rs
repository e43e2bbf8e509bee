//! The program halrun: makes an instance and executes a script.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::programs::halrun::main)
}
