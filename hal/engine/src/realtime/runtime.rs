//! The runtime of an instance: its threads and tasks, and the changes that it brings to them.
//!
//! Only the files of this room see the fields. A method returns the messages that it causes; its
//! caller logs them.

mod threads;

use crate::{
    Error, Options,
    ends::{Activity, Control, Doing, Instance},
    graph::{Graph, Ix},
    os,
    realtime::gaps::{Cause, Gap},
    realtime::overruns,
    realtime::resources::Realtime,
    realtime::runners::Runners,
    realtime::shared::Shared,
    realtime::task::Task,
    realtime::thread::{List, Thread},
    realtime::watchdog::Watchdog,
    sync::Arc,
};
use hal_protocol::{FaultInfo, GapInfo, RealtimeInfo};

/// Longest time that a change may wait for a boundary, in nanoseconds of wall-clock time.
pub(crate) const TIMEOUT_NS: i64 = 2_000_000_000;

/// Data that threads may still be using.
#[derive(Debug)]
enum Retired {
    List(Arc<List>),
    Threads(Arc<Vec<Arc<Thread>>>),
}

impl Retired {
    fn is_free(&self) -> bool {
        1 == match self {
            Self::List(a) => Arc::strong_count(a),
            Self::Threads(a) => Arc::strong_count(a),
        }
    }
}

/// Threads and tasks of an instance.
#[derive(Debug)]
pub(crate) struct Runtime {
    shared: Arc<Shared>,
    /// The data that a report of the end of the process uses.
    instance: Arc<Instance>,
    /// True in a dry run: nothing runs.
    dry_run: bool,
    /// Longest wait for threads, in nanoseconds of wall-clock time.
    settle_ns: i64,
    runners: Runners,
    /// Present from the first `start` on.
    watchdog: Option<Watchdog>,
    realtime: Realtime,
    tasks: Vec<Task>,
    fault: Option<FaultInfo>,
    retired: Vec<Retired>,
    ticks: (u64, i64),
    /// Number of gaps that were reported.
    gaps_told: u32,
    /// Machine time at which running threads were stopped, and the cause, until they are started again.
    halted: Option<(Cause, i64)>,
    /// True if no cycle has begun since threads were stopped.
    quiet: bool,
}

impl Runtime {
    /// Creates a runtime without threads.
    pub(crate) fn new(options: &Options, realtime: Realtime) -> Self {
        let shared = Shared::new(options.clock);
        let stuck_ns = options.realtime.stuck_ns.unwrap_or(0);
        shared.set_stuck_limit(i64::try_from(stuck_ns).unwrap_or(i64::MAX));
        if let Some(ns) = options.realtime.max_gap_ns {
            shared.gaps.set_max(i64::try_from(ns).unwrap_or(i64::MAX));
        }
        let threads = (realtime.scheduling, realtime.cpu);
        Self {
            instance: Instance::new(shared.clone(), &options.place),
            dry_run: false,
            settle_ns: TIMEOUT_NS,
            runners: Runners::new(shared.clone(), threads, options.realtime.idle_us),
            watchdog: None,
            realtime,
            tasks: Vec::new(),
            fault: None,
            retired: Vec::new(),
            ticks: (os::ticks(), os::monotonic_ns()),
            gaps_told: 0,
            halted: None,
            quiet: true,
            shared,
        }
    }

    /// Makes this the runtime of a dry run, in which nothing runs.
    pub(crate) const fn set_dry_run(&mut self) {
        self.dry_run = true;
    }

    /// Returns whether this is a dry run.
    pub(crate) const fn is_dry_run(&self) -> bool {
        self.dry_run
    }

    /// Returns the state that the threads share with the control side.
    pub(crate) const fn shared(&self) -> &Arc<Shared> {
        &self.shared
    }

    /// Returns the data for a report of the end of the process.
    pub(crate) const fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    /// Returns the record of what the control side does.
    pub(crate) fn control(&self) -> &Control {
        &self.instance.control
    }

    /// Returns machine time in nanoseconds.
    pub(crate) fn now(&self) -> i64 {
        self.shared.now()
    }

    /// Returns whether the clock is the virtual one.
    pub(crate) fn is_virtual(&self) -> bool {
        self.shared.is_virtual()
    }

    /// Returns whether threads are started.
    pub(crate) fn is_running(&self) -> bool {
        self.shared.boundary.is_running()
    }

    /// Returns whether no cycle has begun since threads were stopped.
    pub(crate) const fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Returns whether no function runs: threads are stopped or absent, or a function has failed.
    pub(crate) fn is_idle(&self) -> bool {
        let running = self.is_running() && self.shared.fault.get().is_none();
        !running || self.shared.threads.load().is_empty()
    }

    /// Returns whether there are threads.
    pub(crate) fn has_threads(&self) -> bool {
        !self.shared.threads.load().is_empty()
    }

    /// Returns whether a thread is inside a cycle.
    pub(crate) fn is_inside(&self) -> bool {
        self.shared.is_inside()
    }

    /// Returns whether a thread has begun.
    pub(crate) fn has_begun(&self, thread: &Thread) -> bool {
        self.shared.threads.load().iter().any(|t| t.id == thread.id)
    }

    /// Measures the length of a tick of the cycle counter.
    pub(crate) fn measure_ticks(&mut self) {
        let (ticks, ns) =
            (os::ticks().wrapping_sub(self.ticks.0), os::monotonic_ns() - self.ticks.1);
        if ns > 1_000_000 && ticks > 0 && self.shared.tick_ns().to_bits() == 1_f64.to_bits()
            || ns > 100_000_000
        {
            self.shared.set_tick_ns(ns as f64 / ticks as f64);
        }
    }
}

/// Faults.
impl Runtime {
    /// Returns the fault that stopped the threads.
    pub(crate) const fn fault(&self) -> Option<&FaultInfo> {
        self.fault.as_ref()
    }

    /// Records the fault that stopped the threads.
    pub(crate) fn set_fault(&mut self, fault: FaultInfo) {
        self.halt(Cause::Faulted);
        self.fault = Some(fault);
    }

    /// Clears the fault. No thread is inside a cycle.
    pub(crate) fn clear_fault(&mut self) {
        self.fault = None;
        self.shared.fault.clear();
    }

    /// Returns the error that names the thread that does not leave its cycle, if one is inside.
    pub(crate) fn stuck(&self) -> Error {
        let threads = self.shared.threads.load();
        let Some(inside) = threads.iter().find(|t| t.gate.is_inside()) else {
            return Error::ThreadsLate;
        };
        let funct = inside.running().map_or("?".into(), |(_, funct)| funct.as_str().into());
        Error::Stuck { thread: inside.name.as_str().into(), funct }
    }

    /// Returns the function that does not return: as the watchdog found it, or the one whose thread
    /// is still inside after a fault.
    pub(crate) fn stuck_funct(&self) -> Option<FaultInfo> {
        self.shared.stuck.load().as_deref().cloned().or_else(|| self.stuck_still())
    }

    /// Returns the fault that stopped the threads, while its thread is still inside the function.
    fn stuck_still(&self) -> Option<FaultInfo> {
        let fault = self.fault.as_ref().filter(|_| self.shared.fault.is_abandoned())?;
        let (thread, _) = self.shared.fault.get()?;
        let threads = self.shared.threads.load();
        let is_inside = threads.iter().any(|t| t.id == thread && t.gate.is_inside());
        let cause = "it does not come back".to_owned();
        is_inside.then(|| FaultInfo { cause, ..fault.clone() })
    }

    /// Runs the stop actions of components. Returns the messages of those that failed.
    pub(crate) fn run_stops(&self, graph: &Graph, components: &[Ix]) -> Vec<String> {
        let mut failed = Vec::new();
        let _alone = self.shared.stops_alone();
        for ix in components.iter().filter(|_| !self.dry_run) {
            let Some(c) = graph.component(*ix) else { continue };
            let _within = self.control().run(Doing::new(c.name.as_str(), Activity::Stop));
            for stop in &c.stops {
                if let Err(e) = crate::ends::run_stop(stop) {
                    failed.push(format!("{}: stop action: {e}", c.name));
                }
            }
        }
        failed
    }
}

/// Gaps in time.
impl Runtime {
    /// Notes that running threads run no longer: when they are started again, that is a gap.
    pub(in crate::realtime) fn halt(&mut self, cause: Cause) {
        if self.is_running() {
            self.halted = self.halted.or(Some((cause, self.now())));
        }
    }

    /// Counts the gap of threads that start again.
    pub(in crate::realtime) fn end_halt(&mut self) {
        let time_ns = self.now();
        if let Some((cause, since)) = self.halted.take() {
            self.shared.gaps.note(Gap { cause, ns: time_ns - since, time_ns }, None);
        }
    }

    /// Returns the messages about gaps since the last call.
    pub(crate) fn gaps(&mut self) -> Vec<String> {
        let gaps = &self.shared.gaps;
        let told = core::mem::replace(&mut self.gaps_told, gaps.count());
        gaps.since(told).filter_map(|gap| overruns::of_gap(&gap)).collect()
    }

    /// Returns the number of gaps, and the last one; `None` without any.
    pub(crate) fn gap_info(&self) -> Option<GapInfo> {
        let count = self.shared.gaps.count();
        let last = self.shared.gaps.get(count)?;
        Some(GapInfo {
            count,
            ns: u64::try_from(last.ns).unwrap_or(0),
            time: u64::try_from(last.time_ns).unwrap_or(0),
            cause: last.cause.words().to_owned(),
        })
    }
}

/// Realtime resources.
impl Runtime {
    /// Locks memory that was added since, if not all memory may be locked.
    pub(crate) fn lock_more(&self) {
        self.realtime.lock_more();
    }

    /// Returns messages about threads that have missed their time; `ends` reports all that is left.
    pub(crate) fn overruns(&mut self, graph: &Graph, ends: bool) -> Vec<String> {
        self.realtime.overruns(&self.shared, graph, ends)
    }

    /// Returns the description of the scheduling, as a sentence.
    pub(crate) fn scheduling(&self) -> &str {
        &self.realtime.words
    }

    /// Returns the realtime properties of the instance; `None` on the virtual clock.
    pub(crate) fn properties(&self) -> Option<RealtimeInfo> {
        (!self.is_virtual()).then(|| {
            let (idle_us, idle_refusal) = self.runners.idle();
            RealtimeInfo {
                memory: os::memory::locked_and_present().unwrap_or_default(),
                idle_us,
                idle_refusal,
                stuck_ns: self.shared.stuck_limit().unsigned_abs(),
            }
        })
    }
}

/// Background tasks.
impl Runtime {
    /// Adds a task.
    pub(crate) fn add_task(&mut self, task: Task) {
        self.tasks.push(task);
    }

    /// Removes the tasks of a component.
    pub(crate) fn remove_tasks(&mut self, owner: Ix) {
        self.tasks.retain(|t| t.owner != owner);
    }

    /// Returns whether there are tasks.
    pub(crate) const fn has_tasks(&self) -> bool {
        !self.tasks.is_empty()
    }

    /// Returns the time at which the next task is due, in machine time.
    pub(crate) fn next_task(&self) -> i64 {
        self.tasks.iter().filter_map(Task::due).min().unwrap_or(i64::MAX)
    }

    /// Runs every task that is due, in order of creation. Returns the messages of those that
    /// failed.
    pub(crate) fn run_tasks(&mut self, now: i64) -> Vec<String> {
        let control = &self.instance.control;
        let due = self.tasks.iter_mut().filter(|t| t.due().is_some_and(|due| due <= now));
        due.filter_map(|t| t.run(now, control, &self.shared)).collect()
    }
}
