//! The program halsampler: prints the records of a sampler component.

use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(halcmd::programs::halsampler::main)
}
