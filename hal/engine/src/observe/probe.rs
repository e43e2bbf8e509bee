//! Realtime. Probes: values that are read after a cycle, and where they are put.

use crate::{
    graph::own,
    graph::ptr::Ptr,
    observe::ring::Memory,
    sync::{Arc, AtomicBool, AtomicU32, AtomicU64, Ordering},
};
use core::{cell::UnsafeCell, ffi::c_void, ptr::NonNull};
use crossbeam::queue::ArrayQueue;
use hal_abi::{Cell, Producer, Slot};
use hal_protocol::Type;

/// Location of a watched value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Source {
    /// A pin or parameter; a linked pin follows its signal.
    Slot(Ptr<Slot>),
    /// A signal.
    Cell(Ptr<Cell>),
    /// A parameter in its component's own memory.
    Own(Ptr<c_void>, Type),
}

impl Source {
    /// Returns the current value, as the bits of its type.
    #[inline]
    pub(crate) fn bits(&self) -> u64 {
        match self {
            // SAFETY: a slot of the arena; the probe is removed before its pin.
            Self::Slot(p) => unsafe { Slot::cell(p.0.as_ptr()) }.load(),
            // SAFETY: a cell of the arena; as above.
            Self::Cell(p) => unsafe { p.0.as_ref() }.load(),
            Self::Own(p, ty) => own::load(p.0, *ty),
        }
    }

    /// Returns the source for a parameter in its component's own memory.
    pub(crate) const fn own(place: NonNull<c_void>, ty: Type) -> Self {
        Self::Own(Ptr(place), ty)
    }
}

/// Destination of the values.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "there are few probes")]
enum Sink {
    /// Every value, with the time, into a ring that a program reads.
    Records {
        producer: UnsafeCell<Producer>,
        #[expect(dead_code, reason = "held so that the producer's ring stays mapped")]
        memory: Arc<Memory>,
    },
    /// Changed values for the control side: time, index, new bits.
    Changes {
        last: Box<[AtomicU64]>,
        queue: ArrayQueue<(i64, u32, u64)>,
        /// True if the next reading reports every value, changed or not.
        all: AtomicBool,
    },
}

/// A reader of values after each n-th cycle.
#[derive(Debug)]
pub(crate) struct Probe {
    sources: Box<[Source]>,
    sink: Sink,
    every: u32,
    /// Number of cycles to skip before the next reading.
    left: AtomicU32,
    /// Number of readings, and of records or changes lost because the ring or queue was full.
    samples: AtomicU64,
    lost: AtomicU64,
    /// A second count of what was lost, which outlives the process.
    noted: Option<&'static AtomicU64>,
}

// SAFETY: only `sample` changes the producer, and it runs in one thread at a time; `has_room` reads
// the producer only for probes that hold the virtual clock, while no cycle is in progress.
unsafe impl Sync for Probe {}

impl Probe {
    /// Creates a probe that puts whole records into a ring; its first reading is after the next
    /// cycle.
    pub(crate) fn records(sources: Box<[Source]>, every: u32, memory: Arc<Memory>) -> Self {
        let producer = UnsafeCell::new(memory.producer());
        Self::new(sources, every, Sink::Records { producer, memory })
    }

    /// Creates a probe that queues values that differ from the last reading.
    pub(crate) fn changes(sources: Box<[Source]>, last: Box<[AtomicU64]>, room: usize) -> Self {
        Self::new(
            sources,
            1,
            Sink::Changes { last, queue: ArrayQueue::new(room), all: AtomicBool::new(false) },
        )
    }

    const fn new(sources: Box<[Source]>, every: u32, sink: Sink) -> Self {
        let (samples, lost) = (AtomicU64::new(0), AtomicU64::new(0));
        Self { sources, sink, every, left: AtomicU32::new(0), samples, lost, noted: None }
    }

    /// Also counts in `noted` what is lost.
    pub(crate) fn noting(self, noted: Option<&'static AtomicU64>) -> Self {
        Self { noted, ..self }
    }

    /// Reads the values if a reading is due. Runs in one thread at a time.
    pub(crate) fn sample(&self, time: i64) {
        let left = self.left.load(Ordering::Relaxed);
        if left > 0 {
            self.left.store(left - 1, Ordering::Relaxed);
            return;
        }
        self.left.store(self.every.saturating_sub(1), Ordering::Relaxed);
        add_one(&self.samples);
        match &self.sink {
            Sink::Records { producer, .. } => {
                let values = self.sources.iter().map(Source::bits);
                // SAFETY: `sample` runs in one thread at a time.
                let producer = unsafe { &mut *producer.get() };
                if !producer.put_all(core::iter::once(time.cast_unsigned()).chain(values)) {
                    self.lose();
                }
            }
            Sink::Changes { last, queue, all } => {
                let all = all.load(Ordering::Relaxed) && all.swap(false, Ordering::Relaxed);
                for (i, (source, last)) in self.sources.iter().zip(last).enumerate() {
                    let bits = source.bits();
                    if all || bits != last.load(Ordering::Relaxed) {
                        last.store(bits, Ordering::Relaxed);
                        let which = u32::try_from(i).unwrap_or(u32::MAX);
                        if queue.push((time, which, bits)).is_err() {
                            self.lose();
                        }
                    }
                }
            }
        }
    }

    /// Counts a record or change that was lost.
    fn lose(&self) {
        add_one(&self.lost);
        if let Some(noted) = self.noted {
            add_one(noted);
        }
    }

    /// Returns whether the next reading can store everything, even if every value has changed. For
    /// a probe that puts records into a ring, call it only while no cycle is in progress.
    pub(crate) fn has_room(&self) -> bool {
        match &self.sink {
            // SAFETY: the caller ensures that no cycle is in progress, so `sample` is not running.
            Sink::Records { producer, .. } => unsafe { &*producer.get() }.room() > 0,
            Sink::Changes { queue, .. } => queue.capacity() - queue.len() >= self.sources.len(),
        }
    }

    /// Control side: makes the next reading report every value, changed or not.
    pub(crate) fn resync(&self) {
        if let Sink::Changes { all, .. } = &self.sink {
            all.store(true, Ordering::Relaxed);
        }
    }

    /// Control side: removes and returns the oldest change.
    pub(crate) fn change(&self) -> Option<(i64, u32, u64)> {
        match &self.sink {
            Sink::Records { .. } => None,
            Sink::Changes { queue, .. } => queue.pop(),
        }
    }

    /// Control side: returns each value as of the last reading.
    pub(crate) fn last(&self) -> impl Iterator<Item = u64> {
        let last = match &self.sink {
            Sink::Records { .. } => &[],
            Sink::Changes { last, .. } => &**last,
        };
        last.iter().map(|bits| bits.load(Ordering::Relaxed))
    }

    /// Returns the number of readings.
    pub(crate) fn samples(&self) -> u64 {
        // Pairs with `add_one` in `sample`: what the readings before the last one queued is seen.
        self.samples.load(Ordering::Acquire)
    }

    /// Returns the number of records or changes that were lost because the ring or queue was full.
    pub(crate) fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }
}

/// Increments a count that only one thread at a time writes.
fn add_one(count: &AtomicU64) {
    // Pairs with the load in `Probe::samples`.
    count.store(count.load(Ordering::Relaxed).wrapping_add(1), Ordering::Release);
}
