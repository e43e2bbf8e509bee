//! The program halsetup: writes a machine's files from answers.

use halcmd::programs::{halsetup, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("halsetup", words, halsetup::main))
}
