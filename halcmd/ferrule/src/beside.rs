//! The programs beside this one.

use crate::failure::Failure;
use std::{
    os::unix::process::CommandExt as _,
    path::PathBuf,
    process::{Command, ExitCode},
};

/// Returns a program of Ferrule: the one beside this program. One of the same name elsewhere on the path may be LinuxCNC's.
pub(crate) fn find(name: &'static str) -> Result<PathBuf, Failure> {
    let beside = std::env::current_exe().ok().and_then(|exe| Some(exe.parent()?.join(name)));
    beside.filter(|file| file.is_file()).ok_or(Failure::NoProgram { name })
}

/// Returns a program of Ferrule, to be started.
pub(crate) fn command(name: &'static str) -> Result<Command, Failure> {
    Ok(Command::new(find(name)?))
}

/// Becomes another program.
pub(crate) fn instead(name: &'static str, words: &[String]) -> Result<ExitCode, Failure> {
    let error = command(name)?.args(words).exec();
    Err(Failure::NotStarted { name, why: hal_output::reason(&error).into() })
}
