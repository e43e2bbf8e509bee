//! Realtime. Who runs the threads: the virtual clock, or threads of the system.

use crate::{
    os,
    shared::Shared,
    sync::{Arc, Ordering},
    thread::Thread,
};
use std::thread::JoinHandle;

/// Runs the virtual clock up to `until`, at most `instants` moments that do something. Everything
/// due at one moment runs, faster threads first. Returns early when the probe is nearly full or a
/// function fails.
pub(crate) fn turn(shared: &Shared, until: i64, instants: u32) {
    let threads = shared.threads.load();
    let idle = !shared.boundary.is_running() || shared.fault.get().is_some();
    if threads.is_empty() || idle {
        shared.set_now(until);
        for t in threads.iter() {
            let due = t.due.load(Ordering::Relaxed);
            if due <= until {
                let missed = (until - due) / t.period_ns + 1;
                t.due.store(due + missed * t.period_ns, Ordering::Relaxed);
            }
        }
        return;
    }
    let probe = shared.probe.load();
    for _ in 0..instants {
        if probe.as_ref().is_some_and(|p| !p.has_room()) {
            return;
        }
        let next = threads.iter().map(|t| t.due.load(Ordering::Relaxed)).min().unwrap_or(until);
        if next > until {
            shared.set_now(until);
            return;
        }
        shared.set_now(next);
        for t in threads.iter() {
            if t.due.load(Ordering::Relaxed) == next {
                t.due.store(next + t.period_ns, Ordering::Relaxed);
                t.cycle(shared);
            }
        }
        if let Some(p) = probe.as_ref() {
            p.sample(next);
        }
        if shared.fault.get().is_some() {
            return;
        }
    }
}

/// How the system's threads are arranged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scheduling {
    /// Each thread is a thread of the system with `SCHED_FIFO`, all on one processor.
    Fifo,
    /// One thread of the system runs all, from one timeline.
    Timeline,
}

/// The threads of the system that run the real clock.
#[derive(Debug)]
pub(crate) struct Runners {
    shared: Arc<Shared>,
    scheduling: Scheduling,
    cpu: Option<usize>,
    running: Vec<(u32, JoinHandle<()>)>,
}

impl Runners {
    /// None yet.
    pub(crate) fn new(shared: Arc<Shared>, scheduling: Scheduling, cpu: Option<usize>) -> Self {
        Self { shared, scheduling, cpu, running: Vec::new() }
    }

    /// Begins to run a thread that is in `shared.threads` already.
    pub(crate) fn begin(&mut self, thread: &Arc<Thread>, rank: usize) -> std::io::Result<()> {
        let first = thread.due.load(Ordering::Relaxed);
        debug_assert!(first > 0);
        let fifo = self.scheduling == Scheduling::Fifo;
        if !fifo && !self.running.is_empty() {
            return Ok(());
        }
        let (shared, cpu) = (self.shared.clone(), self.cpu);
        let mine = fifo.then(|| thread.clone());
        // Below the kernel's own threads, and below each faster thread.
        let priority = 90_i32.saturating_sub(i32::try_from(rank).unwrap_or(89)).max(1);
        let handle = std::thread::Builder::new().name("hal-thread".into()).spawn(move || {
            if let Some(cpu) = cpu {
                os::stay_on(cpu);
            }
            if fifo {
                os::become_fifo(priority);
            }
            warm(&shared);
            match mine {
                Some(t) => run_one(&shared, &t),
                None => run_all(&shared),
            }
        })?;
        self.running.push((thread.id, handle));
        Ok(())
    }

    /// Waits for threads that were told to end. Those that do not are left behind: false.
    pub(crate) fn end(&mut self, ids: &[u32], all: bool, patience_ns: i64) -> bool {
        let limit = os::monotonic_ns() + patience_ns;
        let leaving = |id: &u32| all || (self.scheduling == Scheduling::Fifo && ids.contains(id));
        let (gone, stay): (Vec<_>, Vec<_>) =
            core::mem::take(&mut self.running).into_iter().partition(|(id, _)| leaving(id));
        self.running = stay;
        let mut clean = true;
        for (_, handle) in gone {
            while !handle.is_finished() && os::monotonic_ns() < limit {
                os::sleep_until(os::monotonic_ns() + 200_000);
            }
            if handle.is_finished() {
                clean &= handle.join().is_ok();
            } else {
                clean = false;
            }
        }
        clean
    }
}

/// Whatever allocates on first use does so before the first cycle.
fn warm(shared: &Shared) {
    drop(shared.threads.load());
    drop(shared.probe.load());
    for t in shared.threads.load().iter() {
        drop(t.list.load());
    }
    os::ticks();
}

/// The fastest thread's duty before its cycle.
fn boundary(shared: &Shared, me: &Thread, threads: &[Arc<Thread>]) {
    if threads.first().is_some_and(|t| t.id == me.id) {
        let others = threads.iter().filter(|t| t.id != me.id).map(|t| &t.gate);
        shared.boundary.take(others, crate::change::Change::carry_out);
    }
}

/// One cycle that was due at `due`; sets when the next is due.
fn beat(shared: &Shared, t: &Thread, threads: &[Arc<Thread>], due: i64) {
    t.woke(os::monotonic_ns() - due);
    boundary(shared, t, threads);
    let longest = t.cycle(shared);
    if threads.first().is_some_and(|f| f.id == t.id)
        && let Some(p) = shared.probe.load().as_ref()
    {
        p.sample(due - shared.origin());
    }
    let mut next = due + t.period_ns;
    let now = os::monotonic_ns();
    if now > next {
        let missed = (now - next) / t.period_ns;
        if shared.boundary.is_running() {
            t.overruns.fetch_add(1, Ordering::Relaxed);
            t.guilty.store(longest, Ordering::Relaxed);
        }
        next += missed * t.period_ns;
    }
    t.due.store(next, Ordering::Relaxed);
}

fn run_one(shared: &Shared, t: &Thread) {
    while !t.end.load(Ordering::Relaxed) && !shared.quit.load(Ordering::Relaxed) {
        let due = t.due.load(Ordering::Relaxed);
        os::sleep_until(due);
        let threads = shared.threads.load();
        beat(shared, t, &threads, due);
    }
}

fn run_all(shared: &Shared) {
    while !shared.quit.load(Ordering::Relaxed) {
        let threads = shared.threads.load();
        let Some(due) = threads.iter().map(|t| t.due.load(Ordering::Relaxed)).min() else {
            drop(threads);
            os::sleep_until(os::monotonic_ns() + 1_000_000);
            continue;
        };
        os::sleep_until(due);
        for t in threads.iter() {
            if t.due.load(Ordering::Relaxed) <= due && !t.end.load(Ordering::Relaxed) {
                beat(shared, t, &threads, t.due.load(Ordering::Relaxed));
            }
        }
    }
}
