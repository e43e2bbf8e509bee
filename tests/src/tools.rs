//! Programs that tests need and a machine may lack ([`hal_golden::tools`]), and how tests find them.

pub use hal_golden::tools::{COMPILER, LINUXCNC, Tool, report};
use std::{
    path::PathBuf,
    process::{Command, Stdio},
};

/// Returns the C compiler's name where there is one; reports the running test as skipped otherwise.
pub fn compiler() -> Option<String> {
    let cc = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let found = Command::new(&cc).arg("--version").output().is_ok_and(|o| o.status.success());
    COMPILER.or_skip(found.then_some(cc))
}

/// Returns the name of the Tcl interpreter where there is one.
pub fn tclsh() -> Option<&'static str> {
    let found = Command::new("tclsh").stdin(Stdio::null()).status();
    found.is_ok_and(|status| status.success()).then_some("tclsh")
}

/// Returns the folder of LinuxCNC's components where its package is installed; reports the running test as skipped
/// otherwise.
pub fn linuxcnc() -> Option<PathBuf> {
    LINUXCNC.or_skip(crate::foreign::installed())
}
