//! Atomics of the standard library; the model checker of `tests/loom` replaces them.

pub(crate) use core::sync::atomic::{AtomicBool, Ordering, fence};
