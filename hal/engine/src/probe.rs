//! Realtime. The probe of a recording: values that the fastest thread looks at after each cycle.

use crate::{
    code::Ptr,
    sync::{AtomicU64, Ordering},
};
use crossbeam::queue::ArrayQueue;
use hal_abi::{Cell, Slot};

/// Where a watched value is.
#[derive(Debug)]
pub(crate) enum Source {
    Slot(Ptr<Slot>),
    Cell(Ptr<Cell>),
}

/// A value, and what it was when it was last looked at.
#[derive(Debug)]
pub(crate) struct Watch {
    pub(crate) source: Source,
    pub(crate) last: AtomicU64,
}

/// Watches values and queues what changed: when, which, to what.
#[derive(Debug)]
pub(crate) struct Probe {
    pub(crate) watches: Vec<Watch>,
    pub(crate) changes: ArrayQueue<(i64, u32, u64)>,
    pub(crate) lost: AtomicU64,
}

impl Probe {
    /// Whether every value could change once without loss.
    pub(crate) fn has_room(&self) -> bool {
        self.changes.capacity() - self.changes.len() >= self.watches.len()
    }

    /// Queues what has changed since the last call. Runs in one thread at a time.
    pub(crate) fn sample(&self, time: i64) {
        for (i, w) in self.watches.iter().enumerate() {
            let bits = match w.source {
                // SAFETY: a slot of the arena; the probe is replaced before its pin goes.
                Source::Slot(p) => unsafe { Slot::cell(p.0.as_ptr()) }.load(),
                // SAFETY: a cell of the arena; as above.
                Source::Cell(p) => unsafe { p.0.as_ref() }.load(),
            };
            if bits != w.last.load(Ordering::Relaxed) {
                w.last.store(bits, Ordering::Relaxed);
                let which = u32::try_from(i).unwrap_or(u32::MAX);
                if self.changes.push((time, which, bits)).is_err() {
                    self.lost.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }
}
