//! The clock of the bench.

use crate::Bench;
use hal_component::abi::HARDWARE_FAILURE;
use std::sync::atomic::Ordering::Relaxed;

impl Bench {
    /// Returns the time of the clock in nanoseconds; to read it takes no time.
    #[must_use]
    pub fn now_ns(&self) -> i64 {
        self.table.borrow().now.load(Relaxed)
    }

    /// Advances the clock by `ns`.
    pub fn pass(&self, ns: i64) {
        self.table.borrow().now.fetch_add(ns, Relaxed);
    }

    /// Lets a part of the hardware fail, or work again.
    pub fn fail_hardware(&self, failed: bool) {
        self.table.borrow().note_hardware(failed);
    }

    /// Returns the number of parts of the hardware that have failed.
    #[must_use]
    pub fn failed_hardware(&self) -> u64 {
        self.table.borrow().failed_hardware.load(Relaxed) % HARDWARE_FAILURE
    }

    /// Counts a gap in time.
    pub fn gap(&self) {
        self.table.borrow().gaps.fetch_add(1, Relaxed);
    }
}
