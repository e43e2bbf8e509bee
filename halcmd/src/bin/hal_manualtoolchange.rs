//! The program `hal_manualtoolchange`: asks a person to change the tool.

use halcmd::programs::{hal_manualtoolchange, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| {
        versioned("hal_manualtoolchange", words, hal_manualtoolchange::main)
    })
}
