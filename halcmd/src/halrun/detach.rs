//! An instance in the background.

use crate::{Terminal, program::is_file, signals::ending_flag};
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

/// In the background: tells the one who waits that the script is done, and gives the terminal
/// free; what goes to a file goes on going there.
pub(super) fn tell() {
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
