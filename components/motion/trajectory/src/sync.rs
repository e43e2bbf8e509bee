//! Atomics. The model checker of `tests/loom` puts its own in their place.

pub(crate) use core::sync::atomic::{AtomicU64, Ordering};
