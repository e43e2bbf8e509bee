//! The program latency-test: how regularly this computer runs realtime threads.

use halcmd::programs::{latency_test, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("latency-test", words, latency_test::main))
}
