//! An instance in the background.

use crate::Terminal;
use rustix::{fs::FileType, pipe::pipe_with, stdio};
use std::{
    fs::File,
    io::Read,
    os::fd::{AsFd, OwnedFd},
    process::{Command, Stdio},
};

const DONE: u8 = b'.';

/// Starts the same in the background and returns when its script is done, with its status.
pub(super) fn parent(words: &[String], terminal: &mut dyn Terminal) -> u8 {
    let started = || -> std::io::Result<u8> {
        let (reader, writer) = pipe_with(rustix::pipe::PipeFlags::CLOEXEC)?;
        let words = words.iter().map(|w| if w == "--detach" { "--detached" } else { w });
        // Its standard input is the way in which it tells that the script is done.
        let mut child = Command::new(std::env::current_exe()?)
            .args(words)
            .stdin(Stdio::from(writer))
            .spawn()?;
        let mut told = [0];
        match File::from(reader).read(&mut told) {
            Ok(1) if told == [DONE] => Ok(0),
            _ => Ok(child.wait()?.code().and_then(|c| u8::try_from(c).ok()).unwrap_or(1)),
        }
    };
    started().unwrap_or_else(|error| {
        terminal.err(&format!("halrun: {}\n", crate::ini::plain(&error)));
        1
    })
}

/// In the background: leaves the terminal, and tells the one who waits that the script is done.
pub(super) fn tell(good: bool) {
    if !good {
        return;
    }
    // A process that leads a group already has none to leave.
    let _ = rustix::process::setsid();
    // Nobody may be waiting any more.
    let _ = rustix::io::write(std::io::stdin(), &[DONE]);
    let Ok(null) = File::options().read(true).write(true).open("/dev/null") else { return };
    let null = OwnedFd::from(null);
    stdio::dup2_stdin(&null).unwrap_or_default();
    if !is_file(std::io::stdout()) {
        stdio::dup2_stdout(&null).unwrap_or_default();
    }
    if !is_file(std::io::stderr()) {
        stdio::dup2_stderr(&null).unwrap_or_default();
    }
}

/// What goes to a file goes on going there; a terminal or a pipe is given free.
fn is_file(fd: impl AsFd) -> bool {
    rustix::fs::fstat(fd).is_ok_and(|s| FileType::from_raw_mode(s.st_mode) == FileType::RegularFile)
}
