//! The program halshow: LinuxCNC's tree of components, pins and signals, for a running instance.

use halcmd::programs::{haltcl, options::versioned};
use std::process::ExitCode;

fn main() -> ExitCode {
    hal_output::program(|words| versioned("halshow", words, haltcl::halshow))
}
