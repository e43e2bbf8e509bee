//! The program halcmd: gives commands to a running instance.

use ::halcmd::programs::{halcmd, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("halcmd", words, halcmd::main))
}
