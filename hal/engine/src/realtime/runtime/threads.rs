//! Start and end of threads, and the delivery of changes to them.

use super::{Retired, Runtime, TIMEOUT_NS};
use crate::{
    Error,
    change::stores::Change,
    graph::arena::Arena,
    os,
    realtime::gaps::Cause,
    realtime::thread::Thread,
    realtime::watchdog::Watchdog,
    sync::{Arc, Ordering},
};

/// Time after [`TIMEOUT_NS`] for which threads that get no processor are waited for, in nanoseconds.
const LATE_NS: i64 = 8_000_000_000;

/// Changes.
impl Runtime {
    /// Carries out a change: directly if no cycle can see a part of it, otherwise at a boundary.
    pub(crate) fn commit(&mut self, change: &Change) -> Result<(), Error> {
        if change.stores.is_empty() && change.lists.is_empty() {
            return Ok(());
        }
        if change.is_atomic() {
            change.apply();
            return Ok(());
        }
        let running = self.is_running() && !self.is_virtual();
        let old: Vec<_> = change.lists.iter().map(|(t, _)| t.list.load_full()).collect();
        if running && self.has_threads() {
            self.at_boundary(change)?;
        } else {
            self.settle()?;
            change.apply();
        }
        self.retired.extend(old.into_iter().map(Retired::List));
        Ok(())
    }

    fn at_boundary(&self, change: &Change) -> Result<(), Error> {
        let boundary = &self.shared.boundary;
        boundary.offer(change);
        // The fastest thread may first have to finish a whole period.
        let round = self.shared.threads.load().first().map_or(0, |t| t.period_ns);
        let limit_ns = self.settle_ns.saturating_add(round);
        self.control().be_patient();
        let taken = self.wait_within(limit_ns, || boundary.is_taken());
        let withdrawn = !taken && boundary.withdraw();
        // A change that cannot be withdrawn is being carried out.
        while !withdrawn && !boundary.is_taken() {
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        self.control().have_waited();
        if withdrawn { Err(self.stuck()) } else { Ok(()) }
    }

    /// Waits for the threads until `done`, for at most `limit_ns`, and longer while no thread gets a
    /// processor. Returns whether it was done.
    fn wait_within(&self, limit_ns: i64, done: impl Fn() -> bool) -> bool {
        let late_ns = if self.settle_ns < TIMEOUT_NS { 0 } else { LATE_NS };
        let limit = os::monotonic_ns().saturating_add(limit_ns);
        let threads = self.shared.threads.load();
        let turns: Vec<_> = threads.iter().map(|t| (t.clone(), t.turn())).collect();
        while !done() {
            let past = os::monotonic_ns().saturating_sub(limit);
            if past > late_ns
                || past > 0 && turns.iter().any(|(t, turn)| t.gate.is_inside() && !turn.is_denied())
            {
                return false;
            }
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        true
    }

    /// Returns whether lists or threads can be freed.
    pub(crate) fn has_garbage(&self) -> bool {
        self.retired.iter().any(Retired::is_free)
    }

    /// Frees lists and threads that no thread uses any more.
    pub(crate) fn free_garbage(&mut self) {
        self.retired.retain(|r| !r.is_free());
    }
}

/// Start and end of threads.
impl Runtime {
    /// Waits until no cycle is in progress. The caller has stopped the threads.
    pub(crate) fn settle(&mut self) -> Result<(), Error> {
        if self.quiet || self.is_virtual() {
            return Ok(());
        }
        self.control().be_patient();
        let quiet = || !self.shared.is_inside();
        self.quiet = self.wait_within(self.settle_ns, quiet);
        self.control().have_waited();
        if self.quiet { Ok(()) } else { Err(self.stuck()) }
    }

    /// Prepares for running threads. Returns the messages about missing rights.
    pub(crate) fn prepare(&mut self) -> Vec<String> {
        self.measure_ticks();
        self.quiet = false;
        if self.dry_run {
            return Vec::new();
        }
        if self.watchdog.is_none() {
            self.watchdog = Watchdog::begin(self.shared.clone());
        }
        if self.is_virtual() { Vec::new() } else { self.realtime.begin(&self.shared) }
    }

    /// Lets threads run. Their lists are up to date, and [`Self::prepare`] was called.
    pub(crate) fn start(&mut self) {
        self.end_halt();
        self.shared.boundary.start();
    }

    /// Stops the threads by command.
    pub(crate) fn stop_by_command(&mut self) -> Result<(), Error> {
        self.halt(Cause::Commanded);
        self.stop()
    }

    /// Prevents further cycles, and waits for those in progress.
    pub(crate) fn stop(&mut self) -> Result<(), Error> {
        self.shared.boundary.stop();
        self.settle()
    }

    /// Stops the threads when the instance ends: waits for a cycle in progress for at most
    /// `limit_ns`. Returns whether all threads have stopped.
    pub(crate) fn stop_within(&mut self, limit_ns: i64) -> bool {
        let limit = core::mem::replace(&mut self.settle_ns, limit_ns);
        let prompt = self.stop().is_ok();
        self.settle_ns = limit;
        prompt
    }

    /// Lets no later step wait for threads again.
    pub(crate) const fn wait_no_more(&mut self) {
        self.settle_ns = 0;
    }

    /// Returns whether steps still wait for threads.
    pub(crate) const fn waits(&self) -> bool {
        self.settle_ns > 0
    }

    /// Starts the cycles of a thread.
    pub(crate) fn begin_thread(
        &mut self,
        thread: &Arc<Thread>,
        arena: &Arena,
    ) -> Result<(), Error> {
        if self.dry_run {
            return Ok(());
        }
        let mut all = self.shared.threads.load().to_vec();
        let rank = all.len();
        all.push(thread.clone());
        let old = self.shared.threads.swap(Arc::new(all));
        self.retired.push(Retired::Threads(old));
        if self.is_virtual() {
            return Ok(());
        }
        self.realtime.lock_memory(arena);
        self.runners.begin(thread, rank)?;
        self.realtime.renew_watch();
        Ok(())
    }

    /// Ends threads, given by their numbers. They run no more cycles when this returns. If it
    /// fails, no thread has ended.
    pub(crate) fn end_threads(&mut self, ids: &[u32]) -> Result<(), Error> {
        let old = self.shared.threads.load_full();
        let stay = old.iter().filter(|t| !ids.contains(&t.id)).cloned().collect();
        drop(self.shared.threads.swap(Arc::new(stay)));
        let leaving: Vec<_> = old.iter().filter(|t| ids.contains(&t.id)).collect();
        let tell = |end| leaving.iter().for_each(|t| t.end.store(end, Ordering::Relaxed));
        tell(true);
        if self.is_virtual() || self.have_left(&old, ids) {
            self.retired.push(Retired::Threads(old));
            return Ok(());
        }
        let stuck = self.stuck();
        tell(false);
        let without = self.shared.threads.swap(old.clone());
        self.retired.push(Retired::Threads(without));
        for (rank, t) in old.iter().enumerate() {
            if ids.contains(&t.id) {
                self.runners.begin_again(t, rank)?;
            }
        }
        Err(stuck)
    }

    /// Waits until no system thread runs any of these threads or uses the old list. Returns false
    /// on timeout.
    fn have_left(&mut self, old: &Arc<Vec<Arc<Thread>>>, ids: &[u32]) -> bool {
        let limit = os::monotonic_ns() + TIMEOUT_NS;
        while Arc::strong_count(old) > 1 {
            if os::monotonic_ns() > limit {
                return false;
            }
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        self.runners.end(ids, false, TIMEOUT_NS)
    }

    /// Ends all threads when the instance ends. Returns false if one does not leave its function.
    pub(crate) fn quit(&mut self) -> bool {
        self.shared.quit.store(true, Ordering::Relaxed);
        self.watchdog = None;
        self.control().be_patient();
        let clean = self.runners.end(&[], true, self.settle_ns);
        self.control().have_waited();
        // Up to here, if a stuck function returns, the outputs are driven to their safe levels
        // again.
        self.realtime.end_watch();
        clean
    }

    /// Returns whether the threads were told to end for good.
    pub(crate) fn has_quit(&self) -> bool {
        self.shared.quit.load(Ordering::Relaxed)
    }

    /// Leaks the lists and threads that a thread still uses that never leaves its function.
    pub(crate) fn leak(&mut self) {
        let _left = core::mem::ManuallyDrop::new(core::mem::take(&mut self.retired));
    }
}
