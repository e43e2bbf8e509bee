//! Instances in the background (`--detach`).

use crate::{Terminal, session::program::is_file, terminal::termination::ending_flag};
use hal_protocol::{Folder, Place};
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    pipe::{PipeFlags, pipe_with},
    process::{Pid, Signal, kill_process, setsid},
    stdio,
};
use std::{
    fs::File,
    io::Read,
    os::fd::OwnedFd,
    path::PathBuf,
    process::{Child, Command, Stdio},
    sync::atomic::Ordering::Relaxed,
};

const DONE: u8 = b'.';
const LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 200_000_000 };

/// Starts the same program in the background. Returns the status of its script when that is done.
pub(super) fn parent(words: &[String], terminal: &mut dyn Terminal) -> u8 {
    let started = || -> std::io::Result<u8> {
        let (reader, writer) = pipe_with(PipeFlags::CLOEXEC)?;
        let words = words.iter().map(|w| if w == "--detach" { "--detached" } else { w });
        // The child reports through its standard input that the script is done.
        let child = Command::new(std::env::current_exe()?)
            .args(words)
            .stdin(Stdio::from(writer))
            .spawn()?;
        wait(child, reader)
    };
    started().unwrap_or_else(|error| {
        terminal.err(&format!("halrun: {}\n", crate::ini::plain(&error)));
        1
    })
}

/// Waits until the child reports that its script is done, or ends. If the user interrupts the wait,
/// the child is ended.
fn wait(mut child: Child, reader: OwnedFd) -> std::io::Result<u8> {
    let ending = ending_flag();
    while poll(&mut [PollFd::new(&reader, PollFlags::IN)], Some(&LOOK)).unwrap_or(0) == 0 {
        if ending.load(Relaxed)
            && let Some(pid) = i32::try_from(child.id()).ok().and_then(Pid::from_raw)
        {
            kill_process(pid, Signal::TERM)?;
            break;
        }
    }
    let mut told = [0];
    match File::from(reader).read(&mut told) {
        Ok(1) if told == [DONE] => Ok(0),
        _ => Ok(child.wait()?.code().and_then(|c| u8::try_from(c).ok()).unwrap_or(1)),
    }
}

/// Separates this process and its programs from the terminal. Called by the background process.
pub(super) fn leave_terminal() {
    // A process that leads a group already has none to leave.
    let _ = setsid();
}

/// Redirects standard error to the instance's log, whose path is returned, unless it is a regular
/// file. Called by the background process.
pub(super) fn leave_stderr(place: &Place) -> Option<PathBuf> {
    if is_file(std::io::stderr()) {
        return None;
    }
    if let Ok(log) = Folder::open(place).and_then(|folder| folder.log(place)) {
        stdio::dup2_stderr(&log).unwrap_or_default();
        return Some(place.log());
    }
    stdio::dup2_stderr(&null()?).unwrap_or_default();
    None
}

/// Removes the log of an instance if it is empty.
pub(super) fn forget(place: &Place) {
    let log = place.log();
    if std::fs::metadata(&log).is_ok_and(|log| log.len() == 0) {
        std::fs::remove_file(log).unwrap_or_default();
    }
}

/// Reports to the waiting process that the script is done, and releases the terminal. Standard
/// output is left alone if it is a regular file. Called by the background process.
pub(super) fn tell() {
    // The other process may have stopped waiting.
    let _ = rustix::io::write(std::io::stdin(), &[DONE]);
    let Some(null) = null() else { return };
    stdio::dup2_stdin(&null).unwrap_or_default();
    if !is_file(std::io::stdout()) {
        stdio::dup2_stdout(&null).unwrap_or_default();
    }
}

fn null() -> Option<OwnedFd> {
    File::options().read(true).write(true).open("/dev/null").ok().map(OwnedFd::from)
}
