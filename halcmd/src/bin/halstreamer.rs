//! The program halstreamer: sends records to a streamer component.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::programs::halstreamer::main)
}
