//! The handover between control and realtime sides, under a model checker: every interleaving of a
//! few threads, and every value that their loads may see.
//!
//! The engine's own `handover.rs` is compiled here with the checker's atomics. Each model has a
//! control side, the fastest thread (which applies changes) and one other thread. The data that
//! changes write and cycles read is an `UnsafeCell` of the checker, which detects every unordered
//! access.
#![cfg(all(loom, test))]

mod exchange;
#[path = "../../../hal/engine/src/change/handover.rs"]
mod handover;
mod inverter;
mod models;
mod retired;
mod slots;

/// The contents of the engine's `sync.rs`, from the checker.
mod sync {
    pub(crate) use loom::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, Ordering, fence};

    pub(crate) fn relax() {
        loom::thread::yield_now();
    }
}
