//! Progress of a thread of this process, observed from another thread. Allocates nothing, because
//! it runs while a machine runs.

use rustix::fs::{Mode, OFlags, open};
use std::{io::Write, os::fd::OwnedFd};

/// Returns the kernel's number of the calling thread.
pub(crate) fn this_thread() -> i32 {
    rustix::thread::gettid().as_raw_nonzero().get()
}

/// Activity of a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Doing {
    /// Runs, waits for a processor, or was stopped from outside: the thread does not wait in a call
    /// of its own.
    Runs,
    /// Waits in a system call.
    Waits,
    /// Waits for a disk, a page or a device, and cannot be interrupted.
    WaitsForDevice,
}

/// Returns the processor time that a thread has used, in nanoseconds; `None` if the thread has
/// ended.
pub(crate) fn processor_time(tid: i32) -> Option<i64> {
    // The kernel's number for the clock of one thread: the thread's number with all bits inverted,
    // shifted left by three, plus 4 for "a thread" and 2 for "scheduler time".
    let clock = (!tid << 3) | 6;
    let mut t = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `t` lives across the call; the kernel refuses a thread that has ended.
    let status = unsafe { libc::clock_gettime(clock, &raw mut t) };
    (status == 0).then_some(t.tv_sec * 1_000_000_000 + t.tv_nsec)
}

/// Observation of a thread, from which [`Turn::is_denied`] tells later whether the thread got a
/// processor since.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    tid: i32,
    used_ns: i64,
    begun_ns: i64,
}

impl Turn {
    /// Begins to observe a thread.
    pub(crate) fn begin(tid: i32) -> Self {
        let used_ns = processor_time(tid).unwrap_or(0);
        Self { tid, used_ns, begun_ns: super::monotonic_ns() }
    }

    /// Returns whether the thread would have run since, but mostly waited for a processor: on a
    /// busy computer such a thread is late, not stuck.
    pub(crate) fn is_denied(self) -> bool {
        let used = processor_time(self.tid).map(|now| now.saturating_sub(self.used_ns));
        let passed = super::monotonic_ns().saturating_sub(self.begun_ns);
        used.is_some_and(|used| used < passed / 4) && doing(self.tid) == Doing::Runs
    }
}

/// The kernel's counts of how long a thread has run and waited for a processor.
#[derive(Debug)]
pub(crate) struct Schedule(OwnedFd);

impl Schedule {
    /// Opens the counts of the calling thread; `None` if the kernel has none.
    pub(crate) fn of_this_thread() -> Option<Self> {
        let flags = OFlags::RDONLY | OFlags::CLOEXEC;
        open(c"/proc/thread-self/schedstat", flags, Mode::empty()).ok().map(Self)
    }

    /// Realtime. Returns how long the thread has run and waited for a processor, together, in nanoseconds; `None` if the
    /// kernel does not count.
    pub(crate) fn busy_ns(&self) -> Option<i64> {
        let mut text = [0; 96];
        let n = rustix::io::pread(&self.0, &mut text, 0).ok()?;
        busy(text.get(..n)?)
    }
}

/// Reads the sum from a line `RUN WAIT SLICES`; a thread that has run at all has a run time above 0.
fn busy(line: &[u8]) -> Option<i64> {
    let mut words = core::str::from_utf8(line).ok()?.split_ascii_whitespace();
    let mut next = || words.next()?.parse::<i64>().ok();
    let (ran, waited) = (next()?, next()?);
    (ran > 0).then_some(ran.saturating_add(waited))
}

/// Returns the current activity of a thread.
pub(crate) fn doing(tid: i32) -> Doing {
    let mut path = [0; 48];
    let mut rest = &mut path[..];
    if write!(rest, "/proc/self/task/{tid}/stat\0").is_err() {
        return Doing::Runs;
    }
    let Ok(path) = core::ffi::CStr::from_bytes_until_nul(&path) else { return Doing::Runs };
    let Ok(file) = open(path, OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty()) else {
        return Doing::Runs;
    };
    let mut text = [0; 128];
    let n = rustix::io::read(&file, &mut text).unwrap_or(0);
    state(text.get(..n).unwrap_or_default())
}

/// Reads the state from a line `TID (NAME) STATE …`; the name may contain anything.
fn state(line: &[u8]) -> Doing {
    let after = line.iter().rposition(|b| *b == b')').and_then(|at| line.get(at + 2));
    match after {
        Some(b'S') => Doing::Waits,
        Some(b'D') => Doing::WaitsForDevice,
        _ => Doing::Runs,
    }
}

#[cfg(test)]
mod tests {
    use super::{Doing, Schedule, Turn, busy, doing, processor_time, state, this_thread};

    #[test]
    fn a_thread_that_computes_or_waits_is_not_denied_its_turn() {
        let turn = Turn::begin(this_thread());
        let begun = crate::os::monotonic_ns();
        let mut used = 0;
        while used < 5_000_000 {
            used = processor_time(this_thread()).unwrap() - turn.used_ns;
        }
        let passed = crate::os::monotonic_ns() - begun;
        // On a busy machine this thread may have been denied in truth.
        assert!(!turn.is_denied() || used < passed / 2, "{used} of {passed}");
        // A thread that has used nothing of the time that has passed.
        let denied = Turn { begun_ns: turn.begun_ns - 3_600_000_000_000, ..turn };
        assert!(denied.is_denied());
        let (tell, told) = std::sync::mpsc::channel();
        let (end, ended) = std::sync::mpsc::channel::<()>();
        let waits = std::thread::spawn(move || {
            tell.send(this_thread()).unwrap();
            ended.recv().unwrap_err();
        });
        let tid = told.recv().unwrap();
        while doing(tid) != Doing::Waits {
            std::thread::yield_now();
        }
        assert!(
            !Turn { begun_ns: 0, ..Turn::begin(tid) }.is_denied(),
            "it waits in a call of its own"
        );
        drop(end);
        waits.join().unwrap();
    }

    #[test]
    fn run_time_and_waiting_time_of_a_thread() {
        assert_eq!(busy(b"1002196 2677127 2\n"), Some(3_679_323));
        for line in [&b"0 0 0\n"[..], b"", b"12", b"x y"] {
            assert_eq!(busy(line), None, "{}", String::from_utf8_lossy(line));
        }
        // A kernel without these counts has no file, or zeros in it.
        let Some(schedule) = Schedule::of_this_thread() else { return };
        let Some(before) = schedule.busy_ns() else { return };
        let ran = processor_time(this_thread()).unwrap();
        while processor_time(this_thread()).unwrap() < ran + 20_000_000 {}
        assert!(schedule.busy_ns().unwrap() >= before + 10_000_000);
    }

    #[test]
    fn states() {
        for (line, want) in [
            (&b"12 (hal-thread) R 1 2"[..], Doing::Runs),
            (b"12 (a) D) S 1 2", Doing::Waits),
            (b"12 (hal) D 1", Doing::WaitsForDevice),
            (b"12 (hal) t 1", Doing::Runs),
            (b"12 (hal)", Doing::Runs),
            (b"", Doing::Runs),
        ] {
            assert_eq!(state(line), want, "{}", String::from_utf8_lossy(line));
        }
    }

    #[test]
    fn a_thread_that_computes_has_more_processor_time_and_one_that_waits_has_not() {
        let me = this_thread();
        let before = processor_time(me).unwrap();
        while processor_time(me).unwrap() < before + 1_000_000 {}
        assert_eq!(doing(me), Doing::Runs);
        let (tell, told) = std::sync::mpsc::channel();
        let (end, ended) = std::sync::mpsc::channel::<()>();
        let waits = std::thread::spawn(move || {
            tell.send(this_thread()).unwrap();
            ended.recv().unwrap_err();
        });
        let other = told.recv().unwrap();
        while doing(other) != Doing::Waits {}
        let had = processor_time(other).unwrap();
        while processor_time(me).unwrap() < before + 2_000_000 {}
        assert_eq!(processor_time(other), Some(had));
        drop(end);
        waits.join().unwrap();
        // The kernel lists it for a moment behind its end.
        while processor_time(other).is_some() {}
    }
}
