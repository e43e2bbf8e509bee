//! Realtime. Parts of components' hardware that have failed.

use crate::{
    load::code::keep,
    realtime::shared::Shared,
    sync::{Arc, AtomicU64, Ordering},
};
use core::ffi::c_void;
use hal_abi::HARDWARE_FAILURE;

/// Parts of one component's hardware that have failed. A component that is gone has no hardware.
#[derive(Debug)]
pub(super) struct FailedHardware {
    own: AtomicU64,
    shared: Arc<Shared>,
}

impl FailedHardware {
    pub(super) fn new(shared: Arc<Shared>) -> Self {
        Self { own: AtomicU64::new(0), shared }
    }

    fn note(&self, failed: bool) {
        if failed {
            self.own.fetch_add(1, Ordering::Relaxed);
            self.shared.failed_hardware.fetch_add(HARDWARE_FAILURE | 1, Ordering::Release); // Pairs with `count`.
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

/// Realtime. Returns the number of parts of hardware that have failed now, and that of failures so far in the high half.
///
/// # Safety
/// Called by a component with the context it was given.
pub(super) unsafe extern "C" fn count(ctx: *const c_void) -> u64 {
    keep(ctx).hardware.shared.failed_hardware.load(Ordering::Acquire) // Pairs with `note` and `drop`.
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ClockKind;

    #[test]
    fn failures_are_counted_and_those_of_a_component_that_is_gone_are_none() {
        let shared = Shared::new(ClockKind::Virtual);
        let counts = || {
            let both = shared.failed_hardware.load(Ordering::Acquire);
            (both % HARDWARE_FAILURE, both / HARDWARE_FAILURE)
        };
        let (one, other) =
            (FailedHardware::new(Arc::clone(&shared)), FailedHardware::new(Arc::clone(&shared)));
        for (part, failed, want) in [
            (&one, true, (1, 1)),
            (&one, true, (2, 2)),
            (&other, true, (3, 3)),
            (&other, false, (2, 3)),
            // A component can end no failure but its own.
            (&other, false, (2, 3)),
            (&one, false, (1, 3)),
            (&other, true, (2, 4)),
        ] {
            part.note(failed);
            assert_eq!(counts(), want);
        }
        drop(one);
        assert_eq!(counts(), (1, 4));
        drop(other);
        assert_eq!(counts(), (0, 4));
    }
}
