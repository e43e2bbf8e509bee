//! The atomics of this crate, so that a model checker can stand in for them.

pub(crate) use std::sync::atomic::{
    AtomicBool, AtomicI32, AtomicI64, AtomicPtr, AtomicU8, AtomicU32, AtomicU64,
};
pub(crate) use std::sync::{
    Arc,
    atomic::{Ordering, fence},
};

/// Waits a moment for another thread.
pub(crate) fn relax() {
    core::hint::spin_loop();
}
