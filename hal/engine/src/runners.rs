//! The threads of the system on which the real clock runs.

use crate::{
    clock, os,
    shared::Shared,
    sync::{Arc, Ordering},
    thread::Thread,
};
use std::thread::JoinHandle;

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
            clock::warm(&shared);
            match mine {
                Some(t) => clock::run_one(&shared, &t),
                None => clock::run_all(&shared),
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
