//! Realtime. Probes: values that are looked at after a cycle, and where they are put.

use crate::{
    code::Ptr,
    node::own,
    ring::Memory,
    sync::{Arc, AtomicBool, AtomicU32, AtomicU64, Ordering},
};
use core::{cell::UnsafeCell, ffi::c_void, ptr::NonNull};
use crossbeam::queue::ArrayQueue;
use hal_abi::{Cell, Producer, Slot};
use hal_protocol::Type;

/// Where a watched value is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Source {
    /// A pin or parameter; a pin follows its signal.
    Slot(Ptr<Slot>),
    /// A signal.
    Cell(Ptr<Cell>),
    /// A parameter in its component's own memory.
    Own(Ptr<c_void>, Type),
}

impl Source {
    /// The value now, as its type's bits.
    #[inline]
    pub(crate) fn bits(&self) -> u64 {
        match self {
            // SAFETY: a slot of the arena; the probe is taken away before its pin goes.
            Self::Slot(p) => unsafe { Slot::cell(p.0.as_ptr()) }.load(),
            // SAFETY: a cell of the arena; as above.
            Self::Cell(p) => unsafe { p.0.as_ref() }.load(),
            Self::Own(p, ty) => own::load(p.0, *ty),
        }
    }

    /// That of a parameter in its component's own memory.
    pub(crate) const fn own(place: NonNull<c_void>, ty: Type) -> Self {
        Self::Own(Ptr(place), ty)
    }
}

/// What a probe does with the values.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "there are few probes")]
enum Sink {
    /// Every value, with the time, into a ring that a program reads.
    Records {
        producer: UnsafeCell<Producer>,
        #[expect(dead_code, reason = "held so that the producer's ring stays mapped")]
        memory: Arc<Memory>,
    },
    /// What has changed, for the control side: when, which, to what.
    Changes {
        last: Box<[AtomicU64]>,
        queue: ArrayQueue<(i64, u32, u64)>,
        /// The next look tells every value.
        all: AtomicBool,
    },
}

/// Looks at values after each n-th cycle.
#[derive(Debug)]
pub(crate) struct Probe {
    sources: Box<[Source]>,
    sink: Sink,
    every: u32,
    /// Cycles until the next look.
    left: AtomicU32,
    /// How often it has looked, and how much was lost for want of room.
    looks: AtomicU64,
    lost: AtomicU64,
}

// SAFETY: only `look` uses the producer, and it runs in one thread at a time; `has_room` is called
// where no cycle is under way.
unsafe impl Sync for Probe {}

impl Probe {
    /// One that puts whole records into a ring; its first look is after the next cycle.
    pub(crate) fn records(sources: Box<[Source]>, every: u32, memory: Arc<Memory>) -> Self {
        let producer = UnsafeCell::new(memory.producer());
        Self::new(sources, every, Sink::Records { producer, memory })
    }

    /// One that queues what is no longer as it was last.
    pub(crate) fn changes(sources: Box<[Source]>, last: Box<[AtomicU64]>, room: usize) -> Self {
        Self::new(
            sources,
            1,
            Sink::Changes { last, queue: ArrayQueue::new(room), all: AtomicBool::new(false) },
        )
    }

    const fn new(sources: Box<[Source]>, every: u32, sink: Sink) -> Self {
        let (looks, lost) = (AtomicU64::new(0), AtomicU64::new(0));
        Self { sources, sink, every, left: AtomicU32::new(0), looks, lost }
    }

    /// Looks, if it is time. Runs in one thread at a time.
    pub(crate) fn look(&self, time: i64) {
        let left = self.left.load(Ordering::Relaxed);
        if left > 0 {
            self.left.store(left - 1, Ordering::Relaxed);
            return;
        }
        self.left.store(self.every.saturating_sub(1), Ordering::Relaxed);
        add_one(&self.looks);
        match &self.sink {
            Sink::Records { producer, .. } => {
                let values = self.sources.iter().map(Source::bits);
                // SAFETY: one thread at a time looks.
                let producer = unsafe { &mut *producer.get() };
                if !producer.put_all(core::iter::once(time.cast_unsigned()).chain(values)) {
                    add_one(&self.lost);
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
                            add_one(&self.lost);
                        }
                    }
                }
            }
        }
    }

    /// Whether the next look loses nothing, whatever has changed. Where no cycle is under way.
    pub(crate) fn has_room(&self) -> bool {
        match &self.sink {
            // SAFETY: no cycle is under way, so nobody looks.
            Sink::Records { producer, .. } => unsafe { &*producer.get() }.room() > 0,
            Sink::Changes { queue, .. } => queue.capacity() - queue.len() >= self.sources.len(),
        }
    }

    /// Control side: the next look tells every value, changed or not.
    pub(crate) fn tell_all(&self) {
        if let Sink::Changes { all, .. } = &self.sink {
            all.store(true, Ordering::Relaxed);
        }
    }

    /// Control side: the oldest change.
    pub(crate) fn change(&self) -> Option<(i64, u32, u64)> {
        match &self.sink {
            Sink::Records { .. } => None,
            Sink::Changes { queue, .. } => queue.pop(),
        }
    }

    /// Control side: each value as it was at the last look.
    pub(crate) fn last(&self) -> impl Iterator<Item = u64> {
        let last = match &self.sink {
            Sink::Records { .. } => &[],
            Sink::Changes { last, .. } => &**last,
        };
        last.iter().map(|bits| bits.load(Ordering::Relaxed))
    }

    /// How often it has looked.
    pub(crate) fn looks(&self) -> u64 {
        self.looks.load(Ordering::Acquire)
    }

    /// How many records or changes were lost for want of room.
    pub(crate) fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }
}

/// Counts; one thread at a time does.
fn add_one(count: &AtomicU64) {
    count.store(count.load(Ordering::Relaxed).wrapping_add(1), Ordering::Release);
}
