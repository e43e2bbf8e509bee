//! A first run of a component's set-up in a copy of this process, for `check`, `order` and `graph`:
//! what crashes or never returns there ends the copy, and is a finding.

use crate::{
    load::Loading,
    module::{Exit, Main},
    running, trap,
};
use core::ffi::c_int;
use std::{
    fs::File,
    io::Read,
    os::fd::{AsRawFd, FromRawFd, RawFd},
};

/// How long set-up and its undoing may take, in milliseconds.
const PATIENCE_MS: c_int = 5000;

/// How far the copy has come; what it writes as it gets there.
const IN_MAIN: u8 = b'm';
const IN_EXIT: u8 = b'e';
const DONE: u8 = b'd';

/// Runs `rtapi_app_main` and, when that succeeds, `rtapi_app_exit`, and forgets both.
///
/// # Errors
/// It would have ended this process, or never returned: the entry point, and why.
pub(crate) fn rehearse(loading: &Loading, main: Main, exit: Option<Exit>) -> Result<(), String> {
    let mut ends: [RawFd; 2] = [-1; 2];
    // SAFETY: a place for two numbers.
    if unsafe { libc::pipe2(ends.as_mut_ptr(), libc::O_CLOEXEC) } != 0 {
        return Ok(());
    }
    let [from, to] = ends;
    // SAFETY: opened just now, owned from here on.
    let from = unsafe { File::from_raw_fd(from) };
    // SAFETY: as above.
    let to = unsafe { File::from_raw_fd(to) };
    // SAFETY: the copy runs this thread alone, and what it does is what this one would do next.
    let copy = unsafe { libc::fork() };
    if copy < 0 {
        return Ok(());
    }
    if copy == 0 {
        perform(loading, main, exit, to.as_raw_fd());
    }
    drop(to);
    let (far, came_back) = follow(from);
    if !came_back {
        // SAFETY: a signal to the copy.
        unsafe { libc::kill(copy, libc::SIGKILL) };
    }
    let mut status = 0;
    // SAFETY: a place for the status of the copy, which is nobody else's.
    unsafe { libc::waitpid(copy, &raw mut status, 0) };
    let entry = if far == IN_EXIT { "rtapi_app_exit" } else { "rtapi_app_main" };
    if far == DONE {
        return Ok(());
    }
    if !came_back {
        return Err(format!("{entry} does not return: given up after {} s", PATIENCE_MS / 1000));
    }
    if libc::WIFSIGNALED(status) {
        let signal = libc::WTERMSIG(status);
        return Err(format!("{entry} crashes: {}", trap::named(signal)));
    }
    let code = libc::WEXITSTATUS(status);
    Err(format!("{entry} ends the process, with status {code}"))
}

/// In the copy: everything, unheard.
fn perform(loading: &Loading, main: Main, exit: Option<Exit>, to: RawFd) -> ! {
    let limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: no file for the remains of a process that may crash.
    unsafe { libc::setrlimit(libc::RLIMIT_CORE, &raw const limit) };
    // SAFETY: opens a file.
    let nowhere = unsafe { libc::open(c"/dev/null".as_ptr(), libc::O_RDWR) };
    for fd in 0..=2 {
        // SAFETY: what the copy says would be said twice.
        unsafe { libc::dup2(nowhere, fd) };
    }
    let tell = |far: u8| {
        // SAFETY: a byte of this function's.
        unsafe { libc::write(to, (&raw const far).cast(), 1) };
    };
    tell(IN_MAIN);
    let module = &raw const *loading.module;
    let code = running::within(module, || main());
    if let (0.., Some(exit)) = (code, exit) {
        tell(IN_EXIT);
        running::within(module, || {
            exit();
            0
        });
    }
    tell(DONE);
    // SAFETY: ends the copy, without what this process does at its end.
    unsafe { libc::_exit(0) }
}

/// How far the copy came, and whether it was heard of in time.
fn follow(mut from: File) -> (u8, bool) {
    let mut far = IN_MAIN;
    loop {
        let mut wait = libc::pollfd { fd: from.as_raw_fd(), events: libc::POLLIN, revents: 0 };
        // SAFETY: a record of this function's.
        let ready = unsafe { libc::poll(&raw mut wait, 1, PATIENCE_MS) };
        if ready == 0 {
            return (far, false);
        }
        let mut byte = [0];
        match from.read(&mut byte) {
            Ok(1) => [far] = byte,
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Ok(_) | Err(_) => return (far, true),
        }
    }
}
