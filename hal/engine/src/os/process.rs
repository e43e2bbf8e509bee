//! Processes that this one starts, and their system calls.

use super::RESOLVE_ALL;
use core::{ffi::CStr, ptr::null_mut};

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

/// Returns whether a process is stopped, by a signal or by a debugger.
pub(crate) fn is_stopped(pid: i32) -> bool {
    let stat = std::fs::read(format!("/proc/{pid}/stat")).unwrap_or_default();
    is_stopped_in(&stat)
}

/// Reads the state from a line `PID (NAME) STATE …`; the name may contain anything.
fn is_stopped_in(stat: &[u8]) -> bool {
    let state = stat.iter().rposition(|b| *b == b')').and_then(|at| stat.get(at + 2));
    matches!(state, Some(b'T' | b't'))
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

/// Returns the set of signals that holds SIGCONT alone.
fn only_continue() -> libc::sigset_t {
    // SAFETY: all zero is a valid set.
    let mut set = unsafe { core::mem::zeroed() };
    // SAFETY: a live set.
    unsafe { libc::sigemptyset(&raw mut set) };
    // SAFETY: a live set.
    unsafe { libc::sigaddset(&raw mut set, libc::SIGCONT) };
    set
}

/// Blocks SIGCONT in this thread and in those that it starts: it continues a stopped process all the same, and stays pending
/// until [`take_continue`].
pub(crate) fn keep_continue() {
    let set = only_continue();
    // SAFETY: a live set.
    unsafe { libc::pthread_sigmask(libc::SIG_BLOCK, &raw const set, null_mut()) };
}

/// Runs `act` while this thread does not block SIGCONT, so that a program that it starts does not block it either.
pub(crate) fn with_continue<T>(act: impl FnOnce() -> T) -> T {
    let set = only_continue();
    // SAFETY: all zero is a valid set.
    let mut before = unsafe { core::mem::zeroed() };
    // SAFETY: live sets.
    unsafe { libc::pthread_sigmask(libc::SIG_UNBLOCK, &raw const set, &raw mut before) };
    let done = act();
    // SAFETY: the set that was in force before.
    unsafe { libc::pthread_sigmask(libc::SIG_SETMASK, &raw const before, null_mut()) };
    done
}

/// Realtime. Returns whether the process was continued since the last [`take_continue`], where SIGCONT is blocked.
pub(crate) fn is_continue_pending() -> bool {
    let mut set = only_continue();
    // SAFETY: a live set.
    let status = unsafe { libc::sigpending(&raw mut set) };
    // SAFETY: the set that the system has filled.
    status == 0 && unsafe { libc::sigismember(&raw const set, libc::SIGCONT) } == 1
}

/// Realtime. Removes a pending SIGCONT, where it is blocked, and returns whether there was one. Waits for nothing.
pub(crate) fn take_continue() -> bool {
    if !is_continue_pending() {
        return false;
    }
    let (set, now) = (only_continue(), libc::timespec { tv_sec: 0, tv_nsec: 0 });
    // SAFETY: live records; nothing about the signal is asked for.
    unsafe { libc::sigtimedwait(&raw const set, null_mut(), &raw const now) == libc::SIGCONT }
}

#[cfg(test)]
mod tests {
    use super::{is_continue_pending, is_stopped_in, keep_continue, take_continue, with_continue};

    #[test]
    fn stopped_processes() {
        for (line, want) in [
            (&b"12 (panel) T 1"[..], true),
            (b"12 (panel) t 1", true),
            (b"12 (a) T (b) S 1", false),
            (b"12 (panel) R 1", false),
            (b"12 (T", false),
            (b"", false),
        ] {
            assert_eq!(is_stopped_in(line), want, "{}", String::from_utf8_lossy(line));
        }
        assert!(!super::is_stopped(crate::os::own_pid()));
    }

    #[test]
    fn a_signal_that_continues_stays_until_it_is_taken() {
        // In a thread of its own, whose mask changes.
        let checks = || {
            // SAFETY: it has no conditions.
            let me = unsafe { libc::pthread_self() };
            // SAFETY: a signal to this thread, which ignores it or keeps it.
            let raise = || unsafe { libc::pthread_kill(me, libc::SIGCONT) };
            raise();
            assert!(!is_continue_pending(), "it is not kept");
            keep_continue();
            raise();
            raise();
            assert!(is_continue_pending() && is_continue_pending());
            take_continue();
            assert!(!is_continue_pending());
            take_continue();
            with_continue(raise);
            assert!(!is_continue_pending(), "it was not kept meanwhile");
            raise();
            assert!(is_continue_pending(), "it is kept again");
        };
        std::thread::spawn(checks).join().unwrap();
    }
}
