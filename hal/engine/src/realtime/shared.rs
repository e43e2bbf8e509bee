//! Realtime. State that all threads of an instance and its control side share.

use crate::{
    ClockKind,
    change::handover::Boundary,
    change::stores::Change,
    load::code::Code,
    messages::mailbox::Mailbox,
    os,
    realtime::gaps::{Gaps, Sight},
    realtime::questions::Questions,
    realtime::thread::Thread,
    sync::{Arc, AtomicBool, AtomicI64, AtomicU8, AtomicU32, AtomicU64, Ordering},
};
use arc_swap::{ArcSwap, ArcSwapOption};
use hal_abi::CommandRun;
use hal_protocol::FaultInfo;

/// The first failure of a function.
#[derive(Debug)]
pub(crate) struct Fault {
    /// 0: no fault, 1: being written, 2: recorded.
    state: AtomicU32,
    /// True if cycles in progress end after their current function.
    abandoned: AtomicBool,
    thread: AtomicU32,
    funct: AtomicU32,
    cause: Cause,
}

impl Fault {
    const fn new() -> Self {
        let (state, thread, funct) = (AtomicU32::new(0), AtomicU32::new(0), AtomicU32::new(0));
        let abandoned = AtomicBool::new(false);
        Self { state, abandoned, thread, funct, cause: Cause::new() }
    }

    /// Ends every cycle in progress after its current function.
    pub(crate) fn abandon(&self) {
        self.abandoned.store(true, Ordering::Relaxed);
    }

    /// Returns whether cycles in progress are to end.
    #[inline]
    pub(crate) fn is_abandoned(&self) -> bool {
        self.abandoned.load(Ordering::Relaxed)
    }

    /// Records the first fault. A later failure, in a cycle that was in progress, does not
    /// overwrite its cause.
    pub(crate) fn set(&self, thread: u32, funct: u32, cause: &Cause) {
        // Pairs with itself: the first fault wins.
        if self.state.compare_exchange(0, 1, Ordering::AcqRel, Ordering::Relaxed).is_ok() {
            self.thread.store(thread, Ordering::Relaxed);
            self.funct.store(funct, Ordering::Relaxed);
            self.cause.copy(cause);
            self.state.store(2, Ordering::Release); // Pairs with `get`.
        }
    }

    /// Returns the thread and function, if a function has failed.
    pub(crate) fn get(&self) -> Option<(u32, u32)> {
        let there = self.state.load(Ordering::Acquire) == 2; // Pairs with `set`.
        there.then(|| (self.thread.load(Ordering::Relaxed), self.funct.load(Ordering::Relaxed)))
    }

    /// Control side: returns the text of the failure, once a function has failed.
    pub(crate) const fn cause(&self) -> &Cause {
        &self.cause
    }

    /// Control side: clears the fault while no thread is inside a cycle.
    pub(crate) fn clear(&self) {
        self.abandoned.store(false, Ordering::Relaxed);
        self.state.store(0, Ordering::Release); // Pairs with `set`.
    }
}

/// The text of a panic, stored without allocation.
#[derive(Debug)]
pub(crate) struct Cause {
    len: AtomicU32,
    bytes: [AtomicU8; 256],
}

impl Cause {
    pub(crate) const fn new() -> Self {
        Self { len: AtomicU32::new(0), bytes: [const { AtomicU8::new(0) }; 256] }
    }

    /// Stores the first 256 bytes.
    pub(crate) fn store(&self, text: &str) {
        let mut n = 0;
        for (place, b) in self.bytes.iter().zip(text.bytes()) {
            place.store(b, Ordering::Relaxed);
            n += 1;
        }
        self.len.store(n, Ordering::Release); // Pairs with `bytes`.
    }

    fn copy(&self, from: &Self) {
        for (place, b) in self.bytes.iter().zip(&from.bytes) {
            place.store(b.load(Ordering::Relaxed), Ordering::Relaxed);
        }
        self.len.store(from.len.load(Ordering::Relaxed), Ordering::Release); // Pairs with `bytes`.
    }

    /// Control side: returns the stored bytes and the number of valid ones.
    pub(crate) fn bytes(&self) -> ([u8; 256], usize) {
        let n = self.len.load(Ordering::Acquire) as usize; // Pairs with `store`.
        (core::array::from_fn(|i| self.bytes.get(i).map_or(0, |b| b.load(Ordering::Relaxed))), n)
    }
}

/// End of the virtual clock, in nanoseconds: 146 years. Sums of times stay representable.
pub(crate) const MAX_TIME_NS: i64 = i64::MAX / 2;

/// Longest time that a thread waits for another thread's stop actions, in nanoseconds.
const STOPS_NS: i64 = 2_000_000_000;

/// Returns the first multiple of a period after `now`.
pub(crate) const fn next_multiple(now: i64, period_ns: i64) -> i64 {
    (now.div_euclid(period_ns) + 1).saturating_mul(period_ns)
}

/// The exclusive right to run stop actions.
#[derive(Debug)]
pub(crate) struct Stopping<'a>(&'a AtomicBool);

impl Drop for Stopping<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release); // Pairs with `Shared::stops_alone`.
    }
}

/// State shared by all threads of an instance and its control side.
#[derive(Debug)]
pub(crate) struct Shared {
    clock: ClockKind,
    /// Virtual clock: machine time. Real clock: the monotonic clock's reading at machine time zero.
    /// In nanoseconds.
    time: AtomicI64,
    pub(crate) boundary: Boundary<Change>,
    /// All threads in order of creation, the fastest first.
    pub(crate) threads: ArcSwap<Vec<Arc<Thread>>>,
    pub(crate) fault: Fault,
    /// The thread that does not return, as the watchdog found it.
    pub(crate) stuck: ArcSwapOption<FaultInfo>,
    /// Text of the last panic, until the caller of the code takes it.
    pub(crate) cause: Cause,
    pub(crate) mailbox: Mailbox,
    pub(crate) gaps: Gaps,
    /// Number of parts of hardware, of all components, that have failed now, and of failures so far in the high half.
    pub(crate) failed_hardware: AtomicU64,
    pub(crate) questions: Questions,
    /// Stop actions of all loaded components, which threads other than the control thread may run.
    pub(crate) stops: ArcSwap<Vec<Arc<Code<CommandRun>>>>,
    /// True while a thread runs stop actions.
    stopping: AtomicBool,
    /// Time in one call after which a thread counts as stuck, in nanoseconds; 0: twice the period
    /// of the slowest thread.
    stuck_ns: AtomicI64,
    /// Nanoseconds per tick, as the bits of a float.
    tick_ns: AtomicU64,
    pub(crate) quit: AtomicBool,
}

impl Shared {
    pub(crate) fn new(clock: ClockKind) -> Arc<Self> {
        let start = match clock {
            ClockKind::Real => os::monotonic_ns(),
            ClockKind::Virtual => 0,
        };
        Arc::new(Self {
            clock,
            time: AtomicI64::new(start),
            boundary: Boundary::new(),
            threads: ArcSwap::from_pointee(Vec::default()),
            fault: Fault::new(),
            stuck: ArcSwapOption::empty(),
            cause: Cause::new(),
            mailbox: Mailbox::new(),
            gaps: Gaps::new(),
            failed_hardware: AtomicU64::new(0),
            questions: Questions::default(),
            stops: ArcSwap::from_pointee(Vec::default()),
            stopping: AtomicBool::new(false),
            stuck_ns: AtomicI64::new(0),
            tick_ns: AtomicU64::new(1_f64.to_bits()),
            quit: AtomicBool::new(false),
        })
    }

    pub(crate) fn is_virtual(&self) -> bool {
        self.clock == ClockKind::Virtual
    }

    /// Returns machine time in nanoseconds.
    pub(crate) fn now(&self) -> i64 {
        let t = self.time.load(Ordering::Relaxed);
        match self.clock {
            ClockKind::Virtual => t,
            ClockKind::Real => os::monotonic_ns() - t,
        }
    }

    /// Returns the start of the first cycle of a new thread, on the clock of [`Thread::due`].
    pub(crate) fn first_due(&self, period_ns: i64) -> i64 {
        if self.is_virtual() {
            next_multiple(self.now(), period_ns)
        } else {
            // Leaves one millisecond for the thread to start.
            self.origin() + next_multiple(self.now() + 1_000_000, period_ns)
        }
    }

    /// Sets the virtual clock.
    pub(crate) fn set_now(&self, ns: i64) {
        self.time.store(ns, Ordering::Relaxed);
    }

    /// Returns the monotonic clock's reading at machine time zero.
    pub(crate) fn origin(&self) -> i64 {
        self.time.load(Ordering::Relaxed)
    }

    /// Reserves stop actions for the caller until the returned guard is dropped: a second thread
    /// that wants to run them waits, but only for a limited time, in case the first never finishes.
    pub(crate) fn stops_alone(&self) -> Stopping<'_> {
        let limit = os::monotonic_ns() + STOPS_NS;
        // Pairs with the end of `Stopping`.
        while self.stopping.swap(true, Ordering::Acquire) && os::monotonic_ns() < limit {
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        Stopping(&self.stopping)
    }

    /// Returns what a thread sees at the monotonic time `now_ns`, that was to wake at `due_ns`.
    pub(crate) fn sight(&self, due_ns: i64, now_ns: i64, period_ns: i64) -> Sight {
        Sight {
            due_ns,
            now_ns,
            lead_ns: self.gaps.lead(now_ns),
            period_ns,
            time_ns: now_ns - self.origin(),
            is_running: self.boundary.is_running() && self.fault.get().is_none(),
        }
    }

    /// Returns whether a thread is inside a cycle.
    pub(crate) fn is_inside(&self) -> bool {
        self.threads.load().iter().any(|t| t.gate.is_inside())
    }

    /// Waits until no cycle is in progress, for at most this time. Returns whether none is.
    pub(crate) fn settle_within(&self, limit_ns: i64) -> bool {
        let limit = os::monotonic_ns().saturating_add(limit_ns);
        while self.is_inside() && os::monotonic_ns() <= limit {
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        !self.is_inside()
    }

    /// Waits until no cycle is in progress, for at most two periods of the slowest thread.
    pub(crate) fn wait_for_cycles(&self) {
        self.settle_within(self.two_periods());
    }

    /// Returns twice the period of the slowest thread, in nanoseconds.
    fn two_periods(&self) -> i64 {
        let threads = self.threads.load();
        threads.iter().map(|t| t.period_ns).max().unwrap_or(0).saturating_mul(2)
    }

    /// Drives all outputs to their safe levels. For threads other than the control thread.
    pub(crate) fn stop_outputs(&self) {
        let _alone = self.stops_alone();
        self.stops.load().iter().for_each(|stop| stop.call_mute());
    }

    /// Returns the time in one call of a function after which a thread counts as stuck, in
    /// nanoseconds.
    pub(crate) fn stuck_limit(&self) -> i64 {
        match self.stuck_ns.load(Ordering::Relaxed) {
            0 => self.two_periods(),
            ns => ns,
        }
    }

    /// Control side: sets that time; 0 means twice the period of the slowest thread.
    pub(crate) fn set_stuck_limit(&self, ns: i64) {
        self.stuck_ns.store(ns, Ordering::Relaxed);
    }

    /// Returns the number of nanoseconds per tick.
    pub(crate) fn tick_ns(&self) -> f64 {
        f64::from_bits(self.tick_ns.load(Ordering::Relaxed))
    }

    /// Control side: sets the number of nanoseconds per tick.
    pub(crate) fn set_tick_ns(&self, ns: f64) {
        self.tick_ns.store(ns.to_bits(), Ordering::Relaxed);
    }
}
