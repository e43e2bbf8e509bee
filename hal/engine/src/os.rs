//! System calls of this crate: memory, scheduling, clocks.

pub(crate) mod memory;
pub(crate) mod process;
pub(crate) mod processors;
pub(crate) mod progress;

use core::ptr::{NonNull, null_mut};

/// Flag for opening a library: every symbol is resolved at once, so that no cycle resolves one.
pub(crate) const RESOLVE_ALL: i32 = libc::RTLD_NOW;
/// Flag for opening a library: it stays mapped when it is closed.
pub(crate) const STAY_MAPPED: i32 = libc::RTLD_NODELETE;

/// Reserves address space without memory behind it.
pub(crate) fn reserve(bytes: usize) -> Option<NonNull<u8>> {
    // SAFETY: a fresh anonymous mapping.
    let p = unsafe {
        libc::mmap(
            null_mut(),
            bytes,
            libc::PROT_NONE,
            libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE,
            -1,
            0,
        )
    };
    if p == libc::MAP_FAILED {
        return None;
    }
    let at = NonNull::new(p.cast())?;
    // A reservation is not locked even where all memory is: parts are locked as they are used.
    memory::unlock(at, bytes);
    Some(at)
}

/// Backs a part of a reservation with memory. If `lock` is true and the system allows it, also
/// locks that memory, which makes its pages present.
pub(crate) fn commit(at: NonNull<u8>, bytes: usize, lock: bool) -> bool {
    // SAFETY: within a reservation of ours.
    let status =
        unsafe { libc::mprotect(at.as_ptr().cast(), bytes, libc::PROT_READ | libc::PROT_WRITE) };
    if status != 0 {
        return false;
    }
    if lock {
        // SAFETY: committed above; a refusal only means that pages may fault.
        unsafe { libc::mlock(at.as_ptr().cast(), bytes) };
    }
    true
}

/// Releases a reservation.
///
/// # Safety
/// It came from [`reserve`] with this size, and nothing points into it any more.
pub(crate) unsafe fn release(at: NonNull<u8>, bytes: usize) {
    // SAFETY: the caller's promise.
    unsafe { libc::munmap(at.as_ptr().cast(), bytes) };
}

/// Returns the monotonic clock in nanoseconds.
pub(crate) fn monotonic_ns() -> i64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    t.tv_sec * 1_000_000_000 + t.tv_nsec
}

/// Returns the clock that also counts while the computer sleeps, in nanoseconds.
pub(crate) fn boot_ns() -> i64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::Boottime);
    t.tv_sec * 1_000_000_000 + t.tv_nsec
}

/// Realtime. Sleeps until the monotonic clock reads `ns`.
pub(crate) fn sleep_until(ns: i64) {
    let t = libc::timespec { tv_sec: ns / 1_000_000_000, tv_nsec: ns % 1_000_000_000 };
    loop {
        // SAFETY: `t` lives across the call.
        let e = unsafe {
            libc::clock_nanosleep(
                libc::CLOCK_MONOTONIC,
                libc::TIMER_ABSTIME,
                &raw const t,
                null_mut(),
            )
        };
        if e != libc::EINTR {
            return;
        }
    }
}

/// Realtime. Returns the cycle counter, or nanoseconds on processors without one.
#[inline]
pub(crate) fn ticks() -> u64 {
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: every x86-64 processor has it.
        unsafe { core::arch::x86_64::_rdtsc() }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        monotonic_ns().cast_unsigned()
    }
}

/// Requests `SCHED_FIFO` at `priority` for this thread. Returns whether the system granted it.
pub(crate) fn become_fifo(priority: i32) -> bool {
    // 0 is this thread.
    schedule(0, libc::SCHED_FIFO, priority)
}

/// Takes `SCHED_FIFO` away from a thread of this process. Returns the priority that it had, or
/// `None` if it was an ordinary thread already.
pub(crate) fn take_fifo(tid: i32) -> Option<i32> {
    let mut p = libc::sched_param { sched_priority: 0 };
    // SAFETY: `p` lives across the call; the kernel refuses a thread that has ended.
    let status = unsafe { libc::sched_getparam(tid, &raw mut p) };
    let had = (status == 0).then_some(p.sched_priority).filter(|p| *p > 0)?;
    schedule(tid, libc::SCHED_OTHER, 0).then_some(had)
}

/// Gives a thread back what [`take_fifo`] took.
pub(crate) fn give_fifo(tid: i32, priority: i32) {
    schedule(tid, libc::SCHED_FIFO, priority);
}

fn schedule(tid: i32, policy: libc::c_int, priority: i32) -> bool {
    let p = libc::sched_param { sched_priority: priority };
    // SAFETY: `p` lives across the call; the kernel refuses a thread that has ended.
    unsafe { libc::sched_setscheduler(tid, policy, &raw const p) == 0 }
}

/// Returns the reason why this process may not use `SCHED_FIFO` at `priority`, by trying it on a
/// thread that ends at once.
pub(crate) fn fifo_refusal(priority: i32) -> Option<String> {
    if std::thread::spawn(move || become_fifo(priority)).join().unwrap_or(false) {
        return None;
    }
    let limit = rustix::process::getrlimit(rustix::process::Resource::Rtprio).current;
    Some(match limit {
        Some(limit) => format!("RLIMIT_RTPRIO is {limit} and must be {priority} or more"),
        None => "the system refuses it".to_owned(),
    })
}

/// Ends this process at once, with this status.
pub(crate) fn end_with(status: i32) -> ! {
    // SAFETY: ends the process; no cleanup of this process is needed.
    unsafe { libc::_exit(status) }
}

/// State of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Life {
    /// A process that has not ended.
    Runs,
    /// A process that ended, or whose end is not known.
    Ended,
    /// A child of this process that a signal ended.
    Killed(i32),
}

/// Returns the state of a process. The status of an ended child process is left for the code that started it.
pub(crate) fn life(pid: i32) -> Life {
    use rustix::process::{Pid, WaitId, WaitIdOptions, test_kill_process, waitid};
    let Some(pid) = Pid::from_raw(pid).filter(|_| pid > 1) else { return Life::Ended };
    let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    match waitid(WaitId::Pid(pid), look) {
        Ok(None) => Life::Runs,
        Ok(Some(status)) => status.terminating_signal().map_or(Life::Ended, Life::Killed),
        // Not a child of this process.
        Err(_) if test_kill_process(pid).is_ok() => Life::Runs,
        Err(_) => Life::Ended,
    }
}

/// Returns whether a process exists and has not ended.
pub(crate) fn alive(pid: i32) -> bool {
    life(pid) == Life::Runs
}

/// Returns the number of this process.
pub(crate) fn own_pid() -> i32 {
    rustix::process::getpid().as_raw_nonzero().get()
}

/// Sends SIGTERM, or SIGKILL when `hard`.
pub(crate) fn end_process(pid: i32, hard: bool) {
    if pid > 1 {
        // SAFETY: a plain signal to one process.
        unsafe { libc::kill(pid, if hard { libc::SIGKILL } else { libc::SIGTERM }) };
    }
}

/// Returns the reason of an error in the system's words.
pub(crate) fn said(error: &std::io::Error) -> Box<str> {
    hal_output::reason(error).into()
}
