//! The e-stop: commanded by users, and answered by the chain of contacts outside.

use crate::pins::Pins;
use hal_component::{Estop, Gives, In, Interlock, Takes, Touch};
use std::sync::atomic::{
    AtomicBool, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};

/// What commands, the task and realtime threads share of the e-stop.
#[derive(Debug)]
pub(crate) struct Shared {
    commanded: AtomicBool,
    /// How often it was commanded, wrapping.
    stops: AtomicU32,
    /// In how many cycles the interlock was read, wrapping past zero; 0: in none.
    reads: AtomicU32,
    /// TRUE while a function that has read the interlock no longer does.
    is_unread: AtomicBool,
}

impl Shared {
    /// The machine comes up in e-stop.
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
        // One function reads it; a count that wraps is not 0, which means never.
        let next = self.reads.load(Relaxed).wrapping_add(1);
        self.reads.store(if next == 0 { 1 } else { next }, Relaxed);
    }
}

/// Commands the e-stop: at once, because the task may be a whole cycle away.
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

/// Takes the command back, and asks the outside to close its contacts.
pub(crate) fn release(shared: &Gives<Shared>, p: &Pins) {
    p.user_enable_out.set(true);
    p.user_request_enable.set(true);
    shared.commanded.store(false, Release); // Pairs with `is_commanded`.
}

/// Returns the state of the e-stop in this moment.
pub(crate) fn state(shared: &Shared, emc_enable_in: In<bool>) -> Estop {
    Estop { commanded: shared.is_commanded(), open: !emc_enable_in.get() }
}

/// Realtime. The service that motion reads in every cycle.
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
