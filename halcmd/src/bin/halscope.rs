//! The program halscope: samples any pin, draws the samples, and shows them in the terminal.

use halcmd::programs::{halscope, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("halscope", words, halscope::main))
}
