//! Makes an instance and carries out a script.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::halrun::main)
}
