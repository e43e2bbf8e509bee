//! The program halscope: samples any pin, draws the samples, and shows them in the terminal.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::programs::halscope::main)
}
