//! The atomics of the seqlock, so that a model checker can stand in for them.

pub(crate) use core::sync::atomic::{AtomicU64, Ordering, fence};
