//! The program haltest: runs the tests of machines.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::programs::haltest::main)
}
