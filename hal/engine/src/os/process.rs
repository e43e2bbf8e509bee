//! Processes that this one starts, and what they ask of Linux.

use super::RESOLVE_ALL;
use core::ffi::CStr;

/// What a signal is called.
pub(crate) fn signal_name(signal: i32) -> String {
    let name = match signal {
        libc::SIGSEGV => "a segmentation fault (SIGSEGV)",
        libc::SIGBUS => "a bus error (SIGBUS)",
        libc::SIGILL => "an illegal instruction (SIGILL)",
        libc::SIGFPE => "an arithmetic fault (SIGFPE)",
        libc::SIGABRT => "an abort (SIGABRT)",
        libc::SIGTRAP => "a trap (SIGTRAP)",
        libc::SIGSYS => "a forbidden system call (SIGSYS)",
        libc::SIGKILL => "SIGKILL",
        _ => return format!("signal {signal}"),
    };
    name.to_owned()
}

/// Ends a group of processes, hard.
pub(crate) fn end_group(leader: u32) {
    if let Ok(leader) = i32::try_from(leader)
        && leader > 1
    {
        // SAFETY: a plain signal to the group of one process.
        unsafe { libc::kill(-leader, libc::SIGKILL) };
    }
}

/// Whether the program was started with rights that its caller does not have.
pub(crate) fn is_privileged() -> bool {
    // SAFETY: only asks.
    unsafe { libc::getauxval(libc::AT_SECURE) != 0 }
}

/// From now on this process ends with the thread that started it, and leaves no remains if it
/// crashes.
pub(crate) fn die_with_parent() {
    // SAFETY: a setting of this process.
    unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL) };
    let limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: a record of this function's.
    unsafe { libc::setrlimit(libc::RLIMIT_CORE, &raw const limit) };
}

/// Opens a library for good; false when the system's loader refuses it.
pub(crate) fn open_library(path: &CStr, global: bool) -> bool {
    let visible = if global { libc::RTLD_GLOBAL } else { libc::RTLD_LOCAL };
    // SAFETY: its initialisers run, in a process that is there for that.
    !unsafe { libc::dlopen(path.as_ptr(), RESOLVE_ALL | visible) }.is_null()
}

/// Writes a byte.
pub(crate) fn tell(fd: i32, byte: u8) {
    // SAFETY: a byte of this function's.
    unsafe { libc::write(fd, (&raw const byte).cast(), 1) };
}
