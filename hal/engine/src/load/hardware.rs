//! Realtime. Parts of components' hardware that have failed.

use crate::{
    load::code::keep,
    realtime::shared::Shared,
    sync::{Arc, AtomicU32, Ordering},
};
use core::ffi::c_void;

/// Parts of one component's hardware that have failed. A component that is gone has no hardware.
#[derive(Debug)]
pub(super) struct FailedHardware {
    own: AtomicU32,
    shared: Arc<Shared>,
}

impl FailedHardware {
    pub(super) fn new(shared: Arc<Shared>) -> Self {
        Self { own: AtomicU32::new(0), shared }
    }

    fn note(&self, failed: bool) {
        if failed {
            self.own.fetch_add(1, Ordering::Relaxed);
            self.shared.failed_hardware.fetch_add(1, Ordering::Release); // Pairs with `count`.
        } else if self.own.load(Ordering::Relaxed) > 0 {
            self.own.fetch_sub(1, Ordering::Relaxed);
            self.shared.failed_hardware.fetch_sub(1, Ordering::Release); // Pairs with `count`.
        }
    }
}

impl Drop for FailedHardware {
    fn drop(&mut self) {
        let own = self.own.load(Ordering::Relaxed);
        self.shared.failed_hardware.fetch_sub(own, Ordering::Release); // Pairs with `count`.
    }
}

/// Realtime. Counts a part of the component's hardware that has failed, or that works again.
///
/// # Safety
/// Called by a component with the context it was given.
pub(super) unsafe extern "C" fn note(ctx: *const c_void, failed: u32) {
    keep(ctx).hardware.note(failed != 0);
}

/// Realtime. Returns the number of parts of hardware that have failed.
///
/// # Safety
/// Called by a component with the context it was given.
pub(super) unsafe extern "C" fn count(ctx: *const c_void) -> u32 {
    keep(ctx).hardware.shared.failed_hardware.load(Ordering::Acquire) // Pairs with `note` and `drop`.
}
