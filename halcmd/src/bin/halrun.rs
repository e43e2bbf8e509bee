//! The program halrun: makes an instance and executes a script.

use halcmd::programs::{halrun, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("halrun", words, halrun::main))
}
