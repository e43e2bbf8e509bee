//! The program haltest: runs the tests of machines.

use halcmd::programs::{haltest, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("haltest", words, haltest::main))
}
