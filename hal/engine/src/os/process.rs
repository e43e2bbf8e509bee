//! Processes that this one starts, and their system calls.

use super::RESOLVE_ALL;
use core::ffi::CStr;

/// Returns the name of a signal for messages.
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

/// Kills a group of processes with SIGKILL.
pub(crate) fn end_group(leader: u32) {
    if let Ok(leader) = i32::try_from(leader)
        && leader > 1
    {
        // SAFETY: a plain signal to the group of one process.
        unsafe { libc::kill(-leader, libc::SIGKILL) };
    }
}

/// Returns whether the program was started with rights that its caller does not have.
pub(crate) fn is_privileged() -> bool {
    // SAFETY: only reads a value.
    unsafe { libc::getauxval(libc::AT_SECURE) != 0 }
}

/// Makes this process end with the thread that started it, and leave no core file if it crashes.
pub(crate) fn die_with_parent() {
    // SAFETY: a setting of this process.
    unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL) };
    let limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: a record of this function's.
    unsafe { libc::setrlimit(libc::RLIMIT_CORE, &raw const limit) };
}

/// Opens a library for good; returns false if the system's loader refuses it.
pub(crate) fn open_library(path: &CStr, global: bool) -> bool {
    let visible = if global { libc::RTLD_GLOBAL } else { libc::RTLD_LOCAL };
    // SAFETY: its initialisers run, in a process that exists for that purpose.
    !unsafe { libc::dlopen(path.as_ptr(), RESOLVE_ALL | visible) }.is_null()
}

/// Writes a byte to a file descriptor.
pub(crate) fn tell(fd: i32, byte: u8) {
    // SAFETY: a byte owned by this function.
    unsafe { libc::write(fd, (&raw const byte).cast(), 1) };
}
