//! Trial run of a component's setup in a copy of this process, for `check`, `order` and `graph`: if it crashes or never
//! returns, only the copy ends, and the failure becomes a finding.

use crate::{
    kinematics::Entries,
    load::set_up,
    loading::Loading,
    module::{Exit, Main},
    running, trap,
};
use core::ffi::c_int;
use std::{
    fs::File,
    io::Read,
    os::fd::{AsRawFd, FromRawFd, RawFd},
};

/// Time limit of setup and exit, in milliseconds.
const TIMEOUT_MS: c_int = 5000;

/// Progress of the copy, which it reports as a byte at each step.
const IN_MAIN: u8 = b'm';
const IN_TYPE: u8 = b't';
const IN_SWITCHABLE: u8 = b'a';
const IN_SWITCH: u8 = b's';
const IN_CALL: u8 = b'c';
const IN_EXIT: u8 = b'e';
const DONE: u8 = b'd';

/// Runs `rtapi_app_main` and, if that succeeds, `rtapi_app_exit` in a copy of this process, and discards the copy.
/// Between the two, kinematics report their type, and select each of their types.
///
/// # Errors
/// The setup would have ended this process, or never returned: the error names the entry point and the reason.
pub(crate) fn dry_run_of(
    loading: &Loading,
    main: Main,
    kinematics: Option<Entries>,
    exit: Option<Exit>,
) -> Result<(), String> {
    in_a_copy("", |tell| perform(loading, (main, kinematics, exit), tell))
}

/// Runs one function of a component in a copy of this process, and discards the copy.
///
/// # Errors
/// The function would have ended this process, or never returned; the error names it.
pub(crate) fn of_call(
    loading: &Loading,
    name: &str,
    code: impl FnOnce() -> c_int,
) -> Result<(), String> {
    in_a_copy(name, |tell| {
        tell(IN_CALL);
        running::within(&raw const *loading.module, code);
    })
}

/// Runs code in a copy of this process, which reports its progress. `call` is the name of the function in it that is not
/// an entry point of all modules.
fn in_a_copy(call: &str, code: impl FnOnce(&dyn Fn(u8))) -> Result<(), String> {
    let mut ends: [RawFd; 2] = [-1; 2];
    // SAFETY: memory for two numbers.
    if unsafe { libc::pipe2(ends.as_mut_ptr(), libc::O_CLOEXEC) } != 0 {
        return Ok(());
    }
    let [from, to] = ends;
    // SAFETY: opened just now, owned from here on.
    let from = unsafe { File::from_raw_fd(from) };
    // SAFETY: as above.
    let to = unsafe { File::from_raw_fd(to) };
    // SAFETY: the copy runs this thread only, and does what this thread would do next.
    let copy = unsafe { libc::fork() };
    if copy < 0 {
        return Ok(());
    }
    if copy == 0 {
        be_the_copy(code, to.as_raw_fd());
    }
    drop(to);
    let (far, came_back) = follow(from);
    if !came_back {
        // SAFETY: a signal to the copy.
        unsafe { libc::kill(copy, libc::SIGKILL) };
    }
    let mut status = 0;
    // SAFETY: memory for the status of the copy, for which nothing else waits.
    unsafe { libc::waitpid(copy, &raw mut status, 0) };
    let entry = match far {
        IN_EXIT => "rtapi_app_exit",
        IN_TYPE => "kinematicsType",
        IN_SWITCHABLE => "kinematicsSwitchable",
        IN_SWITCH => "kinematicsSwitch",
        IN_CALL => call,
        _ => "rtapi_app_main",
    };
    if far == DONE {
        return Ok(());
    }
    if !came_back {
        return Err(format!("{entry} does not return: aborted after {} s", TIMEOUT_MS / 1000));
    }
    if libc::WIFSIGNALED(status) {
        let signal = libc::WTERMSIG(status);
        return Err(format!("{entry} crashes: {}", trap::named(signal)));
    }
    let code = libc::WEXITSTATUS(status);
    Err(format!("{entry} ends the process, with status {code}"))
}

/// Runs code in the copy, with its output discarded.
fn be_the_copy(code: impl FnOnce(&dyn Fn(u8)), to: RawFd) -> ! {
    let limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: disables core dumps of a process that may crash.
    unsafe { libc::setrlimit(libc::RLIMIT_CORE, &raw const limit) };
    // SAFETY: opens a file.
    let nowhere = unsafe { libc::open(c"/dev/null".as_ptr(), libc::O_RDWR) };
    for fd in 0..=2 {
        // SAFETY: redirects standard streams of the copy, whose messages would otherwise appear twice.
        unsafe { libc::dup2(nowhere, fd) };
    }
    let tell = |far: u8| {
        // SAFETY: a byte of this function's.
        unsafe { libc::write(to, (&raw const far).cast(), 1) };
    };
    code(&tell);
    tell(DONE);
    // SAFETY: ends the copy without running this process's exit handlers.
    unsafe { libc::_exit(0) }
}

/// Runs setup and exit.
fn perform(
    loading: &Loading,
    (main, kinematics, exit): (Main, Option<Entries>, Option<Exit>),
    tell: &dyn Fn(u8),
) {
    tell(IN_MAIN);
    let module = &raw const *loading.module;
    let done = set_up(&loading.module, main, kinematics, || tell(IN_TYPE));
    if let (Ok(_), Some(kinematics)) = (done, kinematics) {
        tell(IN_SWITCHABLE);
        if running::within(module, || kinematics.switchable()) != 0 {
            tell(IN_SWITCH);
            running::within(module, || kinematics.count_types());
        }
    }
    if let (Ok(_), Some(exit)) = (done, exit) {
        tell(IN_EXIT);
        running::within(module, || {
            exit();
            0
        });
    }
}

/// Follows the copy's progress. Returns the last step, and whether it was reported within the time limit.
fn follow(mut from: File) -> (u8, bool) {
    let mut far = IN_MAIN;
    loop {
        let mut wait = libc::pollfd { fd: from.as_raw_fd(), events: libc::POLLIN, revents: 0 };
        // SAFETY: a record of this function's.
        let ready = unsafe { libc::poll(&raw mut wait, 1, TIMEOUT_MS) };
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
