//! Realtime. The run times of a function or thread, as its pins and parameters show them.

use crate::graph::ptr::Ptr;
use hal_abi::{Cell, Slot};

/// Pins and parameters that show the times of a function or thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Account {
    /// A pin.
    pub(crate) time: Ptr<Slot>,
    /// A parameter, which is never linked.
    pub(crate) tmax: Ptr<Cell>,
    /// A parameter; functions only.
    pub(crate) increased: Option<Ptr<Cell>>,
}

impl Account {
    /// Records a run time in nanoseconds.
    #[inline]
    pub(crate) fn note(&self, ns: i32) {
        // SAFETY: a slot of the arena, alive as long as its component.
        unsafe { Slot::cell(self.time.0.as_ptr()) }.store(u64::from(ns.cast_unsigned()));
        // SAFETY: as above.
        let tmax = unsafe { self.tmax.0.as_ref() };
        let longest = low(tmax.load());
        let more = ns > longest;
        if more {
            tmax.store(u64::from(ns.cast_unsigned()));
        }
        if let Some(increased) = self.increased {
            // SAFETY: as above.
            unsafe { increased.0.as_ref() }.store(u64::from(more));
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "32-bit values live in the low half")]
const fn low(bits: u64) -> i32 {
    (bits as u32).cast_signed()
}
