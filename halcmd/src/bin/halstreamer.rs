//! The program halstreamer: sends records to a streamer component.

use halcmd::programs::{halstreamer, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("halstreamer", words, halstreamer::main))
}
