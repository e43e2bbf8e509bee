//! The program haltcl: Tcl with the commands of HAL.

use halcmd::programs::{haltcl, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("haltcl", words, haltcl::main))
}
