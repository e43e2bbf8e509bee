//! The e-stop: users command it, and the external chain of contacts acknowledges it.

use crate::pins::Pins;
use hal_component::{Estop, Gives, In, Interlock, Takes, Touch};
use std::sync::atomic::{
    AtomicBool, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};

/// State of the e-stop that commands, the task and realtime threads share.
#[derive(Debug)]
pub(crate) struct Shared {
    commanded: AtomicBool,
    /// Number of e-stop commands, wrapping.
    stops: AtomicU32,
    /// Number of cycles in which the interlock was read, wrapping but skipping 0; 0 if it was never read.
    reads: AtomicU32,
    /// True if a function that has read the interlock no longer does.
    is_unread: AtomicBool,
}

impl Shared {
    /// Creates the initial state: the machine comes up in e-stop.
    pub(crate) const fn new() -> Self {
        Self {
            commanded: AtomicBool::new(true),
            stops: AtomicU32::new(0),
            reads: AtomicU32::new(0),
            is_unread: AtomicBool::new(false),
        }
    }

    pub(crate) fn stops(&self) -> u32 {
        self.stops.load(Relaxed)
    }

    pub(crate) fn reads(&self) -> u32 {
        self.reads.load(Relaxed)
    }

    pub(crate) fn set_unread(&self, unread: bool) {
        self.is_unread.store(unread, Relaxed);
    }

    pub(crate) fn is_unread(&self) -> bool {
        self.is_unread.load(Relaxed)
    }

    fn is_commanded(&self) -> bool {
        self.commanded.load(Acquire) // Pairs with `command` and `release`.
    }

    fn read(&self) {
        // One function reads it; 0 means never, so a count that wraps skips it.
        let next = self.reads.load(Relaxed).wrapping_add(1);
        self.reads.store(if next == 0 { 1 } else { next }, Relaxed);
    }
}

/// Commands the e-stop: at once, because the next run of the task may be a whole cycle later.
pub(crate) fn command(shared: &Gives<Shared>, p: &Pins) {
    shared.stops.fetch_add(1, Relaxed);
    shared.commanded.store(true, Release); // Pairs with `is_commanded`.
    for pin in [
        p.user_enable_out,
        p.user_request_enable,
        p.lube,
        p.coolant_mist,
        p.coolant_flood,
        p.tool_prepare,
        p.tool_change,
    ] {
        pin.set(false);
    }
}

/// Withdraws the command, and requests the external contacts to close.
pub(crate) fn release(shared: &Gives<Shared>, p: &Pins) {
    p.user_enable_out.set(true);
    p.user_request_enable.set(true);
    shared.commanded.store(false, Release); // Pairs with `is_commanded`.
}

/// Returns the current state of the e-stop.
pub(crate) fn state(shared: &Shared, emc_enable_in: In<bool>) -> Estop {
    Estop { commanded: shared.is_commanded(), open: !emc_enable_in.get() }
}

/// Realtime. Service that motion reads in every cycle.
#[derive(Debug, Touch)]
pub(crate) struct Service {
    pub(crate) emc_enable_in: In<bool>,
    pub(crate) shared: Takes<Shared>,
}

impl Interlock for Service {
    fn state(&self) -> Estop {
        self.shared.read();
        state(&self.shared, self.emc_enable_in)
    }
}
