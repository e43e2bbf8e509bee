//! The program linuxcnc: starts a machine from its INI file.

use halcmd::programs::{linuxcnc, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("linuxcnc", words, linuxcnc::main))
}
