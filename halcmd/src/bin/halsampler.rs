//! The program halsampler: prints the records of a sampler component.

use halcmd::programs::{halsampler, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("halsampler", words, halsampler::main))
}
