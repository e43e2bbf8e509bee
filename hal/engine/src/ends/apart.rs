//! System calls of the watcher: forking a process of its own, and finding how another process has
//! ended.

use super::{sys, watcher::Status};
use core::ffi::c_int;
use std::{
    collections::BTreeSet,
    fs::File,
    os::fd::{AsRawFd, OwnedFd},
    path::{Path, PathBuf},
};

/// Process in which a call of [`fork_away`] returns.
pub(super) enum Fork {
    Here,
    There,
    Failed,
}

/// Event that the watcher waited for.
pub(super) enum Came {
    Byte(u8),
    /// The other end of the pipe is closed.
    Closed,
    /// The process has ended.
    Ended,
}

/// Returns the thread IDs of this process; empty if they are unknown.
pub(crate) fn threads() -> BTreeSet<c_int> {
    let Ok(all) = std::fs::read_dir("/proc/self/task") else { return BTreeSet::new() };
    all.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok()).collect()
}

/// Returns the program that a process runs; `None` if the process is ending.
pub(super) fn program_of(process: c_int) -> Option<PathBuf> {
    std::fs::read_link(format!("/proc/{process}/exe")).ok()
}

/// Opens a descriptor that becomes readable when a process has ended.
pub(super) fn pidfd(process: c_int) -> Option<OwnedFd> {
    let process = rustix::process::Pid::from_raw(process)?;
    rustix::process::pidfd_open(process, rustix::process::PidfdFlags::empty()).ok()
}

/// Forks. The new process is not a child of this one, so that a component that waits for all of its
/// own children does not wait for it.
pub(super) fn fork_away() -> Fork {
    // SAFETY: this process has one thread, so that the fork interrupts no other.
    let child = unsafe { libc::fork() };
    if child < 0 {
        return Fork::Failed;
    }
    if child > 0 {
        // SAFETY: this process's own child, which ends at once.
        unsafe { libc::waitpid(child, core::ptr::null_mut(), 0) };
        return Fork::Here;
    }
    // SAFETY: as above.
    match unsafe { libc::fork() } {
        0 => Fork::There,
        _ => sys::leave(0),
    }
}

/// Detaches the new process: it has no terminal, no signals, and no files but the given ones and
/// standard error.
pub(super) fn be_apart(files: &[&OwnedFd]) {
    // SAFETY: always possible for a process that leads no group.
    unsafe { libc::setsid() };
    // SAFETY: a text that ends in zero.
    unsafe { libc::prctl(libc::PR_SET_NAME, c"halrun-watch".as_ptr()) };
    let mut all = sys::empty_set();
    // SAFETY: a live set.
    unsafe { libc::sigfillset(&raw mut all) };
    sys::block(&all);
    redirect(&[libc::STDIN_FILENO, libc::STDOUT_FILENO]);
    let mut keep: Vec<c_int> = files.iter().map(|f| f.as_raw_fd()).collect();
    keep.sort_unstable();
    let mut from = libc::STDERR_FILENO + 1;
    for file in keep.into_iter().chain([c_int::MAX]) {
        close_between(from, file.saturating_sub(1));
        from = file.saturating_add(1);
    }
}

fn close_between(first: c_int, last: c_int) {
    if first <= last {
        let (first, last) = (first.cast_unsigned(), last.cast_unsigned());
        // SAFETY: nothing of this process uses them.
        unsafe { libc::syscall(libc::SYS_close_range, first, last, 0) };
    }
}

/// Redirects standard error to the log file, or to nowhere, unless it is a regular file already.
pub(super) fn print_elsewhere(log: Option<&Path>) {
    let is_file = rustix::fs::fstat(std::io::stderr()).is_ok_and(|s| {
        rustix::fs::FileType::from_raw_mode(s.st_mode) == rustix::fs::FileType::RegularFile
    });
    if is_file {
        return;
    }
    match log.and_then(|log| File::options().append(true).open(log).ok()) {
        // If the system refuses, the terminal stays.
        Some(log) => rustix::stdio::dup2_stderr(&log).unwrap_or_default(),
        None => redirect(&[libc::STDERR_FILENO]),
    }
}

fn redirect(files: &[c_int]) {
    let Ok(null) = File::options().read(true).write(true).open("/dev/null") else { return };
    for file in files {
        // SAFETY: two open files.
        unsafe { libc::dup2(null.as_raw_fd(), *file) };
    }
}

/// Waits until the process has ended, a byte arrives, or the pipe is closed.
pub(super) fn wait_for(pidfd: &OwnedFd, end: &OwnedFd, is_same: impl Fn() -> bool) -> Came {
    use rustix::event::{PollFd, PollFlags, poll};
    loop {
        let mut fds = [PollFd::new(pidfd, PollFlags::IN), PollFd::new(end, PollFlags::IN)];
        if poll(&mut fds, None).is_err() {
            continue;
        }
        let [ended, came] = fds.map(|f| f.revents());
        if !ended.is_empty() {
            return Came::Ended;
        }
        let mut byte = [0];
        if !came.is_empty() {
            return match rustix::io::read(end, &mut byte) {
                Ok(1) => Came::Byte(byte[0]),
                _ if is_same() && ends_soon(pidfd) => Came::Ended,
                _ => Came::Closed,
            };
        }
    }
}

fn ends_soon(process: &OwnedFd) -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let limit = Timespec { tv_sec: 1, tv_nsec: 0 };
    poll(&mut [PollFd::new(process, PollFlags::IN)], Some(&limit)).is_ok_and(|n| n > 0)
}

/// Returns the status of an ended process that is not a child of this one. Linux reports it while
/// the parent has not yet collected the status and, if recent enough, also afterwards.
pub(super) fn status_of(process: c_int, pidfd: &OwnedFd) -> Status {
    for _ in 0..100 {
        let code = left_behind(process).or_else(|| told_by(pidfd));
        if let Some(code) = code {
            return Status::of(code);
        }
        sys::nap(1);
    }
    Status::Unknown
}

/// Returns the status of a process whose parent has not collected it: the last field of its `stat`
/// file.
fn left_behind(process: c_int) -> Option<c_int> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let mut fields = stat.rsplit(')').next()?.split_whitespace();
    let is_dead = matches!(fields.next(), Some("Z" | "X"));
    is_dead.then(|| fields.last()?.parse().ok())?
}

/// Returns the status of a process whose parent has collected it, with `PIDFD_GET_INFO`.
fn told_by(pidfd: &OwnedFd) -> Option<c_int> {
    const EXIT: u64 = 1 << 3;
    const GET_INFO: libc::c_ulong = 0xC040_FF0B;
    /// The kernel's record `pidfd_info`.
    #[repr(C)]
    #[derive(Default)]
    struct Info {
        mask: u64,
        cgroup: u64,
        numbers: [u32; 11],
        exit_code: i32,
    }
    let mut info = Info { mask: EXIT, ..Info::default() };
    // SAFETY: a live record of the size that the number of the request says.
    let done = unsafe { libc::ioctl(pidfd.as_raw_fd(), GET_INFO, &raw mut info) };
    (done == 0 && info.mask & EXIT != 0).then_some(info.exit_code)
}
