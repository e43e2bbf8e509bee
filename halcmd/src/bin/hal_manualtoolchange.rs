//! The program `hal_manualtoolchange`: asks a person to change the tool.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::programs::hal_manualtoolchange::main)
}
