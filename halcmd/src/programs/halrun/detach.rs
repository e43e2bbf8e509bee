//! An instance in the background.

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

/// Starts the same in the background and returns when its script is done, with its status.
pub(super) fn parent(words: &[String], terminal: &mut dyn Terminal) -> u8 {
    let started = || -> std::io::Result<u8> {
        let (reader, writer) = pipe_with(PipeFlags::CLOEXEC)?;
        let words = words.iter().map(|w| if w == "--detach" { "--detached" } else { w });
        // Its standard input is the way in which it tells that the script is done.
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

/// Until the other one says that its script is done, or ends. Who gives up waiting ends it.
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

/// In the background: what happens at the terminal does not reach this process and its programs.
pub(super) fn leave_terminal() {
    // A process that leads a group already has none to leave.
    let _ = setsid();
}

/// In the background: what is said from now on goes to the instance's log, whose path this returns,
/// and not to the terminal. Standard error that is a file stays what it is.
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

/// Removes the log of an instance that has ended well and said nothing.
pub(super) fn forget(place: &Place) {
    let log = place.log();
    if std::fs::metadata(&log).is_ok_and(|log| log.len() == 0) {
        std::fs::remove_file(log).unwrap_or_default();
    }
}

/// In the background: tells the process that waits that the script is done, and gives the terminal
/// free. Standard output that is a file stays what it is.
pub(super) fn tell() {
    // Nobody may be waiting any more.
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
