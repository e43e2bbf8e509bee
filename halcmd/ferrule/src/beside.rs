//! The programs beside this one.

use crate::error::Error;
use std::{
    os::unix::process::CommandExt as _,
    path::PathBuf,
    process::{Command, ExitCode},
};

/// Returns a program of Ferrule: the one beside this program, or the first on the path.
pub(crate) fn find(name: &'static str) -> Result<PathBuf, Error> {
    let beside = std::env::current_exe().ok().and_then(|exe| Some(exe.parent()?.join(name)));
    let path = std::env::var_os("PATH").unwrap_or_default();
    let on_path = std::env::split_paths(&path).map(|folder| folder.join(name));
    beside.into_iter().chain(on_path).find(|file| file.is_file()).ok_or(Error::NoProgram { name })
}

/// Returns a program of Ferrule, to be started.
pub(crate) fn command(name: &'static str) -> Result<Command, Error> {
    Ok(Command::new(find(name)?))
}

/// Becomes another program.
pub(crate) fn instead(name: &'static str, words: &[String]) -> Result<ExitCode, Error> {
    let error = command(name)?.args(words).exec();
    Err(Error::NotStarted { name, why: hal_output::reason(&error) })
}
