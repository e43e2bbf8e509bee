//! Checks, prints, draws and tidies G-code without a machine.

use halcmd::programs::{halgcode, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("halgcode", words, halgcode::main))
}
