//! The system threads on which the real clock runs.

use crate::{
    Error,
    ends::Stack,
    os,
    realtime::clock,
    realtime::resources::FASTEST_PRIORITY,
    realtime::shared::Shared,
    realtime::thread::Thread,
    sync::{Arc, Ordering},
};
use std::{fs::File, thread::JoinHandle};

/// Stack size of a thread in bytes; all of it is present before the first cycle.
const STACK: usize = 1 << 20;

/// Arrangement of the system threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scheduling {
    /// Each HAL thread is a system thread with `SCHED_FIFO`, all on one processor.
    Fifo,
    /// A single system thread runs all HAL threads, from one timeline.
    Timeline,
}

/// The system threads that run the real clock.
#[derive(Debug)]
pub(crate) struct Runners {
    shared: Arc<Shared>,
    scheduling: Scheduling,
    cpu: Option<usize>,
    running: Vec<(u32, JoinHandle<()>)>,
    /// Longest time that processors may take to wake while threads run under `SCHED_FIFO`, in
    /// microseconds.
    idle_us: Option<u32>,
    /// The open file that enforces that limit, or the reason why there is none.
    idle: Option<Result<File, Box<str>>>,
}

impl Runners {
    /// Creates an empty set of runners.
    pub(crate) fn new(
        shared: Arc<Shared>,
        (scheduling, cpu): (Scheduling, Option<usize>),
        idle_us: Option<u32>,
    ) -> Self {
        Self { shared, scheduling, cpu, running: Vec::new(), idle_us, idle: None }
    }

    /// Returns the wake-up limit in microseconds while it is in force, or else the reason why it is
    /// not.
    pub(crate) fn idle(&self) -> (Option<u32>, Option<String>) {
        match &self.idle {
            Some(Ok(_)) => (self.idle_us, None),
            Some(Err(why)) => (None, Some(why.as_ref().to_owned())),
            None => (None, None),
        }
    }

    /// Starts a thread that is already in `shared.threads`.
    pub(crate) fn begin(&mut self, thread: &Arc<Thread>, rank: usize) -> Result<(), Error> {
        let first = thread.due.load(Ordering::Relaxed);
        debug_assert!(first > 0);
        let fifo = self.scheduling == Scheduling::Fifo;
        if !fifo && !self.running.is_empty() {
            return Ok(());
        }
        let (shared, cpu) = (self.shared.clone(), self.cpu);
        let mine = fifo.then(|| thread.clone());
        if fifo && self.idle.is_none() {
            self.idle = self.idle_us.map(os::processors::hold_idle_latency);
        }
        let rank = i32::try_from(rank).unwrap_or(FASTEST_PRIORITY);
        let priority = FASTEST_PRIORITY.saturating_sub(rank).max(1);
        let run = move || {
            let _stack = Stack::new();
            if let Some(cpu) = cpu {
                os::processors::stay_on(cpu);
            }
            if fifo {
                os::become_fifo(priority);
                os::memory::keep_stack();
            }
            clock::warm(&shared);
            match mine {
                Some(t) => clock::run_one(&shared, &t),
                None => clock::run_all(&shared),
            }
        };
        let named = std::thread::Builder::new().name("hal-thread".into()).stack_size(STACK);
        let handle = named.spawn(run).map_err(|e| Error::System {
            what: "no thread of the system could be started",
            why: os::said(&e),
        })?;
        self.running.push((thread.id, handle));
        Ok(())
    }

    /// Starts a thread again that had been asked to end and may have done so.
    pub(crate) fn begin_again(&mut self, thread: &Arc<Thread>, rank: usize) -> Result<(), Error> {
        let runs = |(id, handle): &(u32, JoinHandle<()>)| *id == thread.id && !handle.is_finished();
        if self.scheduling == Scheduling::Timeline || self.running.iter().any(runs) {
            return Ok(());
        }
        self.running.retain(|(id, _)| *id != thread.id);
        self.begin(thread, rank)
    }

    /// Waits for threads that were asked to end. Returns false if one of them does not end in time.
    pub(crate) fn end(&mut self, ids: &[u32], all: bool, patience_ns: i64) -> bool {
        let fifo = self.scheduling == Scheduling::Fifo;
        let leaving = |id: &u32| all || (fifo && ids.contains(id));
        let limit = os::monotonic_ns().saturating_add(patience_ns);
        while self.running.iter().any(|(id, handle)| leaving(id) && !handle.is_finished()) {
            if os::monotonic_ns() > limit {
                return false;
            }
            os::sleep_until(os::monotonic_ns() + 200_000);
        }
        self.running.retain(|(id, _)| !leaving(id));
        if self.running.is_empty() {
            self.idle = None;
        }
        true
    }
}
