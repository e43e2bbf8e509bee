//! Realtime. A thread and its cycle: run the functions, time them, count the heartbeat.

use crate::{
    change::handover::Gate,
    ends::{Current, begin_cycle, end_cycle},
    graph::ptr::Ptr,
    load::code::Code,
    name::Name,
    observe::probe::Probe,
    os::{self, progress::Turn},
    realtime::account::Account,
    realtime::shared::Shared,
    sync::{Arc, AtomicBool, AtomicI32, AtomicI64, AtomicU32, AtomicU64, Ordering},
};
use arc_swap::ArcSwap;
use core::ffi::c_void;
use hal_abi::{Run, Slot};

/// A function in a list: everything that a cycle reads, and nothing else.
#[derive(Debug)]
pub(crate) struct Entry {
    run: Run,
    state: *mut c_void,
    account: Account,
    /// The function's number, for reports.
    id: u32,
}

// SAFETY: one thread walks a list; the state is only used by running the code.
unsafe impl Send for Entry {}
// SAFETY: as for `Send`.
unsafe impl Sync for Entry {}

/// The part of a function in a list that no cycle reads.
#[derive(Debug)]
pub(crate) struct Label {
    /// The function's number.
    pub(crate) id: u32,
    /// Names of the function and its component, for reports.
    pub(crate) name: Name,
    pub(crate) component: Name,
    /// Held so that the state lives as long as the list.
    pub(crate) code: Arc<Code<Run>>,
}

impl Label {
    /// Returns the entry of the function.
    pub(crate) fn entry(&self, account: Account) -> Entry {
        Entry { run: self.code.run, state: self.code.state, account, id: self.id }
    }
}

/// The functions and probes of a thread.
#[derive(Debug, Default)]
pub(crate) struct List {
    /// Functions that run once, in a cycle of their own, before all others.
    pub(crate) init: Vec<Entry>,
    /// Functions that run in every cycle.
    pub(crate) entries: Vec<Entry>,
    /// Names and states of all functions.
    pub(crate) labels: Vec<Label>,
    /// Probes that read after each cycle.
    pub(crate) probes: Vec<Arc<Probe>>,
    /// Probes that read even when no function runs: those of the fastest thread, on the real clock.
    pub(crate) idle_probes: Vec<Arc<Probe>>,
}

/// Number of wake-up latency bins: up to 1 µs, 2 µs, 4 µs, … and more.
pub(crate) const BINS: usize = 16;

pub(crate) use crate::ends::NOBODY;

/// A thread.
#[derive(Debug)]
pub(crate) struct Thread {
    pub(crate) id: u32,
    pub(crate) name: Name,
    pub(crate) period_ns: i64,
    pub(crate) list: ArcSwap<List>,
    pub(crate) gate: Gate,
    pub(crate) account: Account,
    pub(crate) beat: Ptr<Slot>,
    /// Start of the next cycle, in nanoseconds: machine time on the virtual clock, monotonic time
    /// on the real one.
    pub(crate) due: AtomicI64,
    pub(crate) cycles: AtomicU64,
    /// Number of cycles that ended after the next one was due.
    pub(crate) overruns: AtomicU64,
    /// Number of cycles that never began, because another cycle took their time or the process was
    /// stopped.
    pub(crate) missed: AtomicU64,
    /// Data of the last overrun: the function that took longest (`NOBODY` if the cycle began later
    /// than it took, or if functions are not timed), how late the cycle began and how long it took,
    /// in nanoseconds.
    pub(crate) guilty: AtomicU32,
    pub(crate) over_late: AtomicI64,
    pub(crate) over_took: AtomicI64,
    /// The kernel's number of the system thread that runs this thread.
    pub(crate) tid: AtomicI32,
    pub(crate) current: Current,
    pub(crate) init_done: AtomicBool,
    /// True if functions are timed.
    pub(crate) timed: AtomicBool,
    pub(crate) latest: AtomicI64,
    pub(crate) latency: [AtomicU64; BINS],
    pub(crate) end: AtomicBool,
}

impl Thread {
    pub(crate) fn new(
        (id, name): (u32, Name),
        period_ns: i64,
        account: Account,
        beat: Ptr<Slot>,
        timed: bool,
        due: i64,
    ) -> Self {
        let current = Current::new(name.as_str());
        Self {
            id,
            name,
            period_ns,
            list: ArcSwap::from_pointee(List::default()),
            gate: Gate::new(),
            account,
            beat,
            due: AtomicI64::new(due),
            cycles: AtomicU64::new(0),
            overruns: AtomicU64::new(0),
            missed: AtomicU64::new(0),
            guilty: AtomicU32::new(NOBODY),
            over_late: AtomicI64::new(0),
            over_took: AtomicI64::new(0),
            tid: AtomicI32::new(0),
            current,
            init_done: AtomicBool::new(false),
            timed: AtomicBool::new(timed),
            latest: AtomicI64::new(0),
            latency: [const { AtomicU64::new(0) }; BINS],
            end: AtomicBool::new(false),
        }
    }

    /// Begins to observe whether this thread gets a processor.
    pub(crate) fn turn(&self) -> Turn {
        Turn::begin(self.tid.load(Ordering::Relaxed))
    }

    /// Runs one cycle at this machine time, if threads are started. Returns the function that took
    /// longest, for the report of an overrun.
    pub(crate) fn cycle(&self, shared: &Shared, time: i64) -> u32 {
        if !shared.boundary.enter(&self.gate) {
            return NOBODY;
        }
        begin_cycle(self);
        let mut longest = NOBODY;
        let list = self.list.load();
        if shared.fault.get().is_none() {
            if self.init_done.load(Ordering::Relaxed) || list.init.is_empty() {
                self.init_done.store(true, Ordering::Relaxed);
                longest = if self.timed.load(Ordering::Relaxed) {
                    self.run_timed(&list.entries, shared)
                } else {
                    self.run(&list.entries, shared)
                };
            } else {
                self.run(&list.init, shared);
                self.init_done.store(true, Ordering::Relaxed);
            }
            let n = self.cycles.load(Ordering::Relaxed).wrapping_add(1);
            self.cycles.store(n, Ordering::Relaxed);
            // SAFETY: a slot of the arena, alive as long as the thread.
            unsafe { Slot::cell(self.beat.0.as_ptr()) }.store(n);
            list.probes.iter().for_each(|p| p.sample(time));
        }
        list.idle_probes.iter().for_each(|p| p.sample(time));
        drop(list);
        end_cycle();
        self.gate.leave();
        longest
    }

    #[inline]
    fn run(&self, entries: &[Entry], shared: &Shared) -> u32 {
        for e in entries {
            self.current.store(e.id, Ordering::Relaxed);
            // SAFETY: only this thread runs the function, and the list keeps it alive.
            if !unsafe { (e.run)(e.state, self.period_ns) }.is_ok() {
                shared.fault.set(self.id, e.id, &shared.cause);
                break;
            }
            if shared.fault.is_abandoned() {
                break;
            }
        }
        self.current.store(NOBODY, Ordering::Relaxed);
        NOBODY
    }

    /// Runs the functions as `run` does, with one reading of the cycle counter between neighbours.
    fn run_timed(&self, entries: &[Entry], shared: &Shared) -> u32 {
        let tick = Tick::new(shared.tick_ns());
        let begin = os::ticks();
        let (mut last, mut most, mut longest) = (begin, 0, NOBODY);
        for e in entries {
            self.current.store(e.id, Ordering::Relaxed);
            // SAFETY: only this thread runs the function, and the list keeps it alive.
            let status = unsafe { (e.run)(e.state, self.period_ns) };
            let now = os::ticks();
            let ticks = now.wrapping_sub(last);
            last = now;
            e.account.note(tick.ns(ticks));
            if ticks > most {
                (most, longest) = (ticks, e.id);
            }
            if !status.is_ok() {
                shared.fault.set(self.id, e.id, &shared.cause);
                break;
            }
            if shared.fault.is_abandoned() {
                break;
            }
        }
        self.current.store(NOBODY, Ordering::Relaxed);
        self.account.note(tick.ns(last.wrapping_sub(begin)));
        longest
    }

    /// Returns the component and the function that the thread runs now.
    pub(crate) fn running(&self) -> Option<(Name, Name)> {
        let current = self.current.load(Ordering::Relaxed);
        let list = self.list.load();
        let mut labels = list.labels.iter();
        let entry = labels.find(|e| e.id == current && current != NOBODY)?;
        Some((entry.component.clone(), entry.name.clone()))
    }

    /// Records that a cycle ended after the next was due, and the number of cycles that were
    /// skipped.
    pub(crate) fn overran(&self, longest: u32, late_ns: i64, took_ns: i64, missed: i64) {
        self.overruns.fetch_add(1, Ordering::Relaxed);
        self.missed.fetch_add(missed.unsigned_abs(), Ordering::Relaxed);
        let guilty = if late_ns > took_ns { NOBODY } else { longest };
        self.guilty.store(guilty, Ordering::Relaxed);
        self.over_late.store(late_ns, Ordering::Relaxed);
        self.over_took.store(took_ns, Ordering::Relaxed);
    }

    /// Records how late a cycle began.
    pub(crate) fn woke(&self, late_ns: i64) {
        if late_ns > self.latest.load(Ordering::Relaxed) {
            self.latest.store(late_ns, Ordering::Relaxed);
        }
        let us = u64::try_from(late_ns / 1000).unwrap_or(0);
        let bin = (u64::BITS - us.leading_zeros()) as usize;
        let bin = if bin < BINS { bin } else { BINS - 1 };
        if let Some(count) = self.latency.get(bin) {
            count.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Half of the bits of a [`Tick`] after its point, as a factor.
const TICK_SCALE: f64 = 268_435_456.0;

/// Duration of a tick of the cycle counter, in nanoseconds times 2^56: a product of integers costs
/// less than a conversion to a float and back.
#[derive(Clone, Copy, Debug)]
struct Tick(u64);

impl Tick {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float saturates; a tick is positive"
    )]
    fn new(ns: f64) -> Self {
        Self((ns * TICK_SCALE * TICK_SCALE) as u64)
    }

    /// Returns whole nanoseconds, or the maximum.
    #[inline]
    fn ns(self, ticks: u64) -> i32 {
        i32::try_from((u128::from(ticks) * u128::from(self.0)) >> 56).unwrap_or(i32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::Tick;

    #[test]
    fn ticks_are_nanoseconds() {
        for (tick_ns, ticks, ns) in [
            (1.0, 17, 17),
            (0.5, 17, 8),
            (0.333_333_333_4, 3_000_000, 1_000_000),
            (0.4, 5_000_000_000, 2_000_000_000),
            (0.4, 5_500_000_000, i32::MAX),
            (1.0, u64::MAX, i32::MAX),
            (41.666, 0, 0),
        ] {
            assert_eq!(Tick::new(tick_ns).ns(ticks), ns, "{ticks} of {tick_ns} ns");
        }
    }
}
