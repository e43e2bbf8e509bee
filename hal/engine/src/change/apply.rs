//! Delivery of a change to the threads, their start and stop, and the release of retired data.

use crate::{
    Engine, Error,
    change::stores::{Change, Store},
    os,
    realtime::thread::{List, Thread},
    realtime::watchdog::Watchdog,
    sync::Arc,
};
use hal_protocol::Lock;
use std::collections::BTreeSet;

/// Longest time that a change may wait for a boundary, in nanoseconds of wall-clock time.
pub(crate) const TIMEOUT_NS: i64 = 2_000_000_000;

/// Data that threads may still be using.
#[derive(Debug)]
pub(crate) enum Retired {
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

/// Splits stores into those that touch only places that no thread can see, and the rest. A store
/// that shares a place with an earlier store of the rest stays with the rest, after it.
pub(crate) fn part(stores: Vec<Store>, fresh: impl Fn(usize) -> bool) -> (Vec<Store>, Vec<Store>) {
    let mut shared = BTreeSet::new();
    stores.into_iter().partition(|store| {
        let places = store.places();
        let early = places.iter().all(|p| fresh(*p) && !shared.contains(p));
        if !early {
            shared.extend(places);
        }
        early
    })
}

impl Engine {
    /// Carries out a change: directly if no cycle can see a part of it, otherwise at a boundary.
    pub(crate) fn carry_out(&mut self, change: &Change) -> Result<(), Error> {
        if change.stores.is_empty() && change.lists.is_empty() {
            return Ok(());
        }
        if change.is_atomic() {
            change.carry_out();
            return Ok(());
        }
        let running = self.shared.boundary.is_running() && !self.shared.is_virtual();
        let threads = !self.shared.threads.load().is_empty();
        let old: Vec<_> = change.lists.iter().map(|(t, _)| t.list.load_full()).collect();
        if running && threads {
            self.at_boundary(change)?;
        } else {
            self.settle()?;
            change.carry_out();
        }
        self.retired.extend(old.into_iter().map(Retired::List));
        Ok(())
    }

    fn at_boundary(&self, change: &Change) -> Result<(), Error> {
        let boundary = &self.shared.boundary;
        boundary.offer(change);
        // The fastest thread may first have to finish a whole period.
        let round = self.shared.threads.load().first().map_or(0, |t| t.period_ns);
        let limit = os::monotonic_ns().saturating_add(self.settle_ns).saturating_add(round);
        self.instance.control.be_patient();
        while !boundary.is_taken() {
            if os::monotonic_ns() > limit && boundary.withdraw() {
                self.instance.control.have_waited();
                return Err(self.stuck());
            }
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        self.instance.control.have_waited();
        Ok(())
    }

    /// Waits until no cycle is in progress. The caller has stopped the threads.
    pub(crate) fn settle(&mut self) -> Result<(), Error> {
        if self.quiet || self.shared.is_virtual() {
            return Ok(());
        }
        let threads = self.shared.threads.load_full();
        let limit = os::monotonic_ns() + self.settle_ns;
        let inside = || threads.iter().any(|t| t.gate.is_inside());
        self.instance.control.be_patient();
        while inside() && os::monotonic_ns() <= limit {
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        self.instance.control.have_waited();
        self.quiet = !inside();
        if self.quiet { Ok(()) } else { Err(self.stuck()) }
    }

    /// `start`: marks threads to be started at the end of the transaction.
    pub(crate) fn start_threads(&mut self) -> Result<(), Error> {
        self.unlocked(Lock::RUN, "start_threads")?;
        if let Some(f) = &self.fault {
            let in_use = self.graph.functs.get(f.funct.as_str());
            if in_use.is_some_and(|ix| self.graph.is_in_use(*ix)) {
                return Err(Error::Faulted { funct: f.funct.as_str().into() });
            }
        }
        self.staged.starts = self.fault.is_some() || !self.shared.boundary.is_running();
        Ok(())
    }

    /// Lets threads run. Their lists are already up to date.
    pub(crate) fn run_threads(&mut self) {
        if self.recording.is_some() {
            self.begin_recording();
        }
        self.refresh_flight();
        self.measure_ticks();
        self.quiet = false;
        if self.watchdog.is_none() && self.trial.is_none() {
            self.watchdog = Watchdog::begin(self.shared.clone());
        }
        self.begin_realtime();
        self.shared.boundary.start();
        self.graph.sites.has_run();
    }

    /// `stop`: prevents further cycles and waits for those in progress.
    pub(crate) fn stop_threads(&mut self) -> Result<(), Error> {
        self.shared.boundary.stop();
        self.settle()
    }

    /// Keeps a list of threads that may still be in use.
    pub(crate) fn retire_threads(&mut self, old: Arc<Vec<Arc<Thread>>>) {
        self.retired.push(Retired::Threads(old));
    }

    /// Frees data that no thread uses any more.
    pub(crate) fn reap(&mut self) {
        if self.retired.iter().any(Retired::is_free) {
            self.hear();
            self.retired.retain(|r| !r.is_free());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::part;
    use crate::{change::stores::Store, graph::arena::Arena, graph::ptr::Ptr};
    use std::collections::BTreeSet;

    #[test]
    fn stores_that_no_thread_sees_go_first_unless_they_follow_one_that_threads_see() {
        let mut arena = Arena::new(false).unwrap();
        let (shown, new) = (Ptr(arena.slot(0).unwrap()), Ptr(arena.slot(0).unwrap()));
        let (signal, other) = (Ptr(arena.cell(0).unwrap()), Ptr(arena.cell(0).unwrap()));
        let own = crate::graph::ptr::own_cell(new);
        let fresh = BTreeSet::from([new.0.addr().get(), own.0.addr().get(), other.0.addr().get()]);
        let stores = vec![
            Store::Put { cell: own, bits: 1 },
            Store::Bring { slot: new, cell: other },
            Store::Keep { cell: signal, slot: shown },
            Store::Put { cell: other, bits: 2 },
            Store::Bring { slot: new, cell: signal },
            Store::Put { cell: own, bits: 3 },
            Store::Aim { slot: new, distance: 8 },
            Store::Put { cell: other, bits: 4 },
        ];
        let (early, late) = part(stores, |place| fresh.contains(&place));
        let shown: Vec<String> = early.iter().chain(&late).map(|s| format!("{s:?}")).collect();
        let begins = |i: usize, what: &str| assert!(shown[i].starts_with(what), "{shown:#?}");
        assert_eq!((early.len(), late.len()), (5, 3), "{shown:#?}");
        for (i, what) in
            ["Put", "Bring", "Put", "Aim", "Put", "Keep", "Bring", "Put"].iter().enumerate()
        {
            begins(i, what);
        }
    }
}
