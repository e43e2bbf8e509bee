//! Realtime. What all threads of an instance and its control side share.

use crate::{
    ClockKind,
    change::Change,
    code::Code,
    handover::Boundary,
    mailbox::Mailbox,
    os,
    sync::{Arc, AtomicBool, AtomicI64, AtomicU8, AtomicU32, AtomicU64, Ordering},
    thread::Thread,
};
use arc_swap::{ArcSwap, ArcSwapOption};
use hal_abi::CommandRun;
use hal_protocol::FaultInfo;

/// Which function failed, once.
#[derive(Debug)]
pub(crate) struct Fault {
    /// 0 none, 1 being written, 2 there.
    state: AtomicU32,
    /// Cycles under way end after the function that they are in.
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

    /// Ends every cycle under way after the function that it is in.
    pub(crate) fn abandon(&self) {
        self.abandoned.store(true, Ordering::Relaxed);
    }

    /// Whether cycles under way are to end.
    #[inline]
    pub(crate) fn is_abandoned(&self) -> bool {
        self.abandoned.load(Ordering::Relaxed)
    }

    /// Records the first fault. What fails after it, in a cycle that was under way, leaves its
    /// cause alone.
    pub(crate) fn set(&self, thread: u32, funct: u32, cause: &Cause) {
        // Pairs with itself: the first one wins.
        if self.state.compare_exchange(0, 1, Ordering::AcqRel, Ordering::Relaxed).is_ok() {
            self.thread.store(thread, Ordering::Relaxed);
            self.funct.store(funct, Ordering::Relaxed);
            self.cause.copy(cause);
            self.state.store(2, Ordering::Release); // Pairs with `get`.
        }
    }

    /// Thread and function, if one has failed.
    pub(crate) fn get(&self) -> Option<(u32, u32)> {
        let there = self.state.load(Ordering::Acquire) == 2; // Pairs with `set`.
        there.then(|| (self.thread.load(Ordering::Relaxed), self.funct.load(Ordering::Relaxed)))
    }

    /// Control side: what the function said, once it has failed.
    pub(crate) const fn cause(&self) -> &Cause {
        &self.cause
    }

    /// Control side: forgets it; no thread is inside a cycle.
    pub(crate) fn clear(&self) {
        self.abandoned.store(false, Ordering::Relaxed);
        self.state.store(0, Ordering::Release); // Pairs with `set`.
    }
}

/// The text of a panic, kept without allocation.
#[derive(Debug)]
pub(crate) struct Cause {
    len: AtomicU32,
    bytes: [AtomicU8; 256],
}

impl Cause {
    pub(crate) const fn new() -> Self {
        Self { len: AtomicU32::new(0), bytes: [const { AtomicU8::new(0) }; 256] }
    }

    /// Keeps the first 256 bytes.
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

    /// Control side: what was kept, and how much of it counts.
    pub(crate) fn bytes(&self) -> ([u8; 256], usize) {
        let n = self.len.load(Ordering::Acquire) as usize; // Pairs with `store`.
        (core::array::from_fn(|i| self.bytes.get(i).map_or(0, |b| b.load(Ordering::Relaxed))), n)
    }
}

/// How long a thread waits for another's stop actions.
const STOPS_NS: i64 = 2_000_000_000;

/// The right to run stop actions.
#[derive(Debug)]
pub(crate) struct Stopping<'a>(&'a AtomicBool);

impl Drop for Stopping<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release); // Pairs with `Shared::stops_alone`.
    }
}

/// Shared by all threads of an instance and its control side.
#[derive(Debug)]
pub(crate) struct Shared {
    clock: ClockKind,
    /// Virtual: machine time. Real: the monotonic clock at machine time zero.
    time: AtomicI64,
    pub(crate) boundary: Boundary<Change>,
    /// In order of creation: the fastest first.
    pub(crate) threads: ArcSwap<Vec<Arc<Thread>>>,
    pub(crate) fault: Fault,
    /// Who does not come back, as the watchdog sees it.
    pub(crate) stuck: ArcSwapOption<FaultInfo>,
    /// What the last panic said, until whoever ran the code takes it.
    pub(crate) cause: Cause,
    pub(crate) mailbox: Mailbox,
    /// What is run from beside the control side: the stop actions of everything that is loaded.
    pub(crate) stops: ArcSwap<Vec<Arc<Code<CommandRun>>>>,
    /// Some thread runs stop actions.
    stopping: AtomicBool,
    /// After how many nanoseconds in one call a thread is stuck; 0: two of the slowest periods.
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

    /// Machine time in nanoseconds.
    pub(crate) fn now(&self) -> i64 {
        let t = self.time.load(Ordering::Relaxed);
        match self.clock {
            ClockKind::Virtual => t,
            ClockKind::Real => os::monotonic_ns() - t,
        }
    }

    /// Turns the virtual clock.
    pub(crate) fn set_now(&self, ns: i64) {
        self.time.store(ns, Ordering::Relaxed);
    }

    /// Machine time zero on the monotonic clock.
    pub(crate) fn origin(&self) -> i64 {
        self.time.load(Ordering::Relaxed)
    }

    /// Keeps stop actions to the caller until what is returned is dropped: of two threads that want
    /// to run them the second waits. One that does not come back keeps nobody for ever.
    pub(crate) fn stops_alone(&self) -> Stopping<'_> {
        let limit = os::monotonic_ns() + STOPS_NS;
        // Pairs with the end of `Stopping`.
        while self.stopping.swap(true, Ordering::Acquire) && os::monotonic_ns() < limit {
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        Stopping(&self.stopping)
    }

    /// Drives all outputs to their safe levels, from beside the control side.
    pub(crate) fn stop_outputs(&self) {
        let _alone = self.stops_alone();
        self.stops.load().iter().for_each(|stop| stop.call_mute());
    }

    /// After how many nanoseconds in one call of a function a thread is stuck.
    pub(crate) fn stuck_limit(&self) -> i64 {
        match self.stuck_ns.load(Ordering::Relaxed) {
            0 => {
                let threads = self.threads.load();
                threads.iter().map(|t| t.period_ns).max().unwrap_or(0).saturating_mul(2)
            }
            ns => ns,
        }
    }

    /// Control side: sets that time; 0 is two of the slowest periods.
    pub(crate) fn set_stuck_limit(&self, ns: i64) {
        self.stuck_ns.store(ns, Ordering::Relaxed);
    }

    /// Nanoseconds for a number of ticks.
    pub(crate) fn tick_ns(&self) -> f64 {
        f64::from_bits(self.tick_ns.load(Ordering::Relaxed))
    }

    /// Control side: how long a tick is.
    pub(crate) fn set_tick_ns(&self, ns: f64) {
        self.tick_ns.store(ns.to_bits(), Ordering::Relaxed);
    }
}
