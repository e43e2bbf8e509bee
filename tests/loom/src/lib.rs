//! The hand-over between control and realtime sides, under a model checker: every interleaving
//! of a few threads, and every value that their loads may see.
//!
//! The engine's own `handover.rs` is compiled here with the checker's atomics. Each model has a
//! control side, the fastest thread (which carries changes out) and one other thread. What a
//! change writes and cycles read is an `UnsafeCell` of the checker: it finds any access that is
//! not ordered.
#![cfg(all(loom, test))]

#[path = "../../../hal/engine/src/change/handover.rs"]
mod handover;
mod models;
mod retired;

/// What the engine's `sync.rs` offers, from the checker.
mod sync {
    pub(crate) use loom::sync::atomic::{AtomicBool, AtomicPtr, Ordering, fence};

    pub(crate) fn relax() {
        loom::thread::yield_now();
    }
}
