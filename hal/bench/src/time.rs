//! The clock of the bench.

use crate::Bench;
use std::sync::atomic::Ordering::Relaxed;

impl Bench {
    /// Advances the clock by `ns`.
    pub fn pass(&self, ns: i64) {
        self.table.borrow().now.fetch_add(ns, Relaxed);
    }

    /// Counts a gap in time.
    pub fn gap(&self) {
        self.table.borrow().gaps.fetch_add(1, Relaxed);
    }
}
