//! Rings and seqlocks between the functions, tasks and workers of a component.

use crate::{
    Builder, Plain, Touch, Uses,
    abi::{access, seqlock},
    ring::Slots,
    sync::{AtomicU64, Ordering},
};
use core::marker::PhantomData;
use std::sync::Arc;

/// Largest number of attempts to copy a record while its writer replaces it.
const ATTEMPTS: u32 = 8;

fn words(n: usize) -> Box<[AtomicU64]> {
    (0..n).map(|_| AtomicU64::new(0)).collect()
}

pub(crate) fn fill<T: Plain>(words: &[AtomicU64], value: &T) {
    // The compiler knows this length, and needs no check for each word.
    let Some(words) = words.get(..T::WORDS) else { return };
    let mut n = 0;
    value.store(&mut |bits| {
        if let Some(word) = words.get(n) {
            word.store(bits, Ordering::Relaxed);
        }
        n += 1;
    });
}

pub(crate) fn fill_some<const FIELDS: u128, T: Plain>(words: &[AtomicU64], value: &T) {
    // The compiler knows this length, as in `fill`.
    let Some(words) = words.get(..T::WORDS) else { return };
    value.store_some::<FIELDS>(&mut |n, bits| {
        if let Some(word) = words.get(n) {
            word.store(bits, Ordering::Relaxed);
        }
    });
}

fn read<T: Plain>(words: &[AtomicU64]) -> T {
    let mut words = words.iter();
    T::load(&mut || words.next().map_or(0, |word| word.load(Ordering::Relaxed)))
}

/// Writing end of a bounded ring of plain records.
#[derive(Debug)]
pub struct RingWriter<T>(Arc<Slots>, PhantomData<fn(T)>);

/// Reading end of a bounded ring of plain records.
#[derive(Debug)]
pub struct RingReader<T>(Arc<Slots>, PhantomData<fn() -> T>);

impl<T: Plain> RingWriter<T> {
    /// Realtime. Appends `value`. Never waits, whatever the reader does.
    ///
    /// # Errors
    /// The ring is full; the error contains the value.
    pub fn put(&mut self, value: T) -> Result<(), T> {
        if self.0.put(|words| fill(words, &value)) { Ok(()) } else { Err(value) }
    }

    /// Realtime. Returns the number of records that the reader has not taken yet.
    #[must_use]
    pub fn waiting(&self) -> u64 {
        self.0.waiting()
    }
}

impl<T: Plain> RingReader<T> {
    /// Realtime. Takes the oldest record, if there is one. Never waits, whatever the writer does.
    pub fn take(&mut self) -> Option<T> {
        self.0.take(read)
    }

    /// Realtime. Returns the number of records that can be taken.
    #[must_use]
    pub fn waiting(&self) -> u64 {
        self.0.waiting()
    }
}

#[derive(Debug)]
struct Seqlock {
    sequence: AtomicU64,
    words: Box<[AtomicU64]>,
}

/// Writing end of a seqlock: the latest value of a plain record.
#[derive(Debug)]
pub struct SeqWriter<T> {
    lock: Arc<Seqlock>,
    number: u64,
    kind: PhantomData<fn(T)>,
}

/// Reading end of a seqlock. Each clone keeps its own last copy.
#[derive(Clone, Debug)]
pub struct SeqReader<T> {
    lock: Arc<Seqlock>,
    last: T,
}

impl<T: Plain> SeqWriter<T> {
    /// Realtime. Replaces the record. Never waits, whatever the readers do.
    pub fn set(&mut self, value: &T) {
        let Seqlock { sequence, words } = &*self.lock;
        seqlock::begin(sequence, self.number);
        fill(words, value);
        seqlock::end(sequence, &mut self.number);
    }
}

impl<T: Plain> SeqReader<T> {
    /// Realtime. Returns the latest record, as a whole. While the writer replaces the record, it
    /// returns the copy before it, after a bounded number of attempts.
    pub fn get(&mut self) -> T {
        for _ in 0..ATTEMPTS {
            let Seqlock { sequence, words } = &*self.lock;
            let mut copied = None;
            if seqlock::read(sequence, || copied = Some(read(words))).is_some()
                && let Some(value) = copied
            {
                self.last = value;
                break;
            }
        }
        self.last
    }
}

macro_rules! ends {
    ($($name:ident, $field:tt, $access:expr;)*) => {$(
        impl<T> Touch for $name<T> {
            fn touch(&self, uses: &mut Uses) {
                uses.hidden(&self.$field, $access);
            }
        }
    )*};
}
ends! {
    RingWriter, 0, access::WRITE;
    RingReader, 0, access::READ;
    SeqWriter, lock, access::WRITE;
    SeqReader, lock, access::READ;
}

impl Builder<'_> {
    /// Creates a ring for at most `room` plain records between two functions, tasks or workers of
    /// this component.
    ///
    /// ```
    /// use hal_component::{
    ///     Builder, Error, Out, Period, Plain, RingReader, RingWriter, Touch, Update,
    /// };
    ///
    /// #[derive(Clone, Copy, Plain)]
    /// struct Point {
    ///     /// Position in machine units.
    ///     position: f64,
    ///     /// True at the last point.
    ///     last: bool,
    /// }
    ///
    /// /// Fills the ring, in a task.
    /// #[derive(Touch)]
    /// struct Plan {
    ///     points: RingWriter<Point>,
    ///     #[state]
    ///     next: f64,
    /// }
    /// impl Update for Plan {
    ///     fn update(&mut self, _: Period) {
    ///         while self.points.put(Point { position: self.next, last: false }).is_ok() {
    ///             self.next += 1.0;
    ///         }
    ///     }
    /// }
    ///
    /// /// Takes one point in each cycle.
    /// #[derive(Touch)]
    /// struct Follow {
    ///     points: RingReader<Point>,
    ///     position: Out<f64>,
    /// }
    /// impl Update for Follow {
    ///     fn update(&mut self, _: Period) {
    ///         if let Some(point) = self.points.take() {
    ///             self.position.set(point.position);
    ///         }
    ///     }
    /// }
    ///
    /// fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    ///     let (writer, points) = b.ring(100);
    ///     let position = b.item("position", "Position in machine units", 0.0)?;
    ///     b.task("plan", "Computes points", 10_000_000, Plan { points: writer, next: 0.0 })?;
    ///     b.function("follow", "Follows points", Follow { points, position })
    /// }
    /// ```
    #[must_use]
    pub fn ring<T: Plain>(&mut self, room: usize) -> (RingWriter<T>, RingReader<T>) {
        let width = T::WORDS.max(1);
        let slots = Arc::new(Slots::over(words(room.max(1) * width), width));
        (RingWriter(slots.clone(), PhantomData), RingReader(slots, PhantomData))
    }

    /// Creates a seqlock that holds the latest value of a plain record, written by one function,
    /// task or worker of this component and read by any number of others.
    ///
    /// ```
    /// use hal_component::{Builder, Error, Period, Plain, SeqReader, SeqWriter, Touch, Update};
    ///
    /// #[derive(Clone, Copy, Default, Plain)]
    /// struct Limits {
    ///     /// Highest velocity in units per second.
    ///     velocity: f64,
    ///     /// Highest acceleration in units per second squared.
    ///     acceleration: f64,
    /// }
    ///
    /// #[derive(Touch)]
    /// struct Move {
    ///     limits: SeqReader<Limits>,
    /// }
    /// impl Update for Move {
    ///     fn update(&mut self, _: Period) {
    ///         let limits = self.limits.get(); // Both values come from the same write.
    ///         assert!(limits.velocity <= limits.acceleration);
    ///     }
    /// }
    ///
    /// fn create(b: &mut Builder<'_>) -> Result<SeqWriter<Limits>, Error> {
    ///     let (writer, limits) = b.seqlock(Limits::default());
    ///     b.function("move", "Moves within limits", Move { limits })?;
    ///     Ok(writer)
    /// }
    /// ```
    #[must_use]
    pub fn seqlock<T: Plain>(&mut self, initial: T) -> (SeqWriter<T>, SeqReader<T>) {
        let lock = Seqlock { sequence: AtomicU64::new(0), words: words(T::WORDS) };
        fill(&lock.words, &initial);
        let lock = Arc::new(lock);
        let writer = SeqWriter { lock: lock.clone(), number: 0, kind: PhantomData };
        (writer, SeqReader { lock, last: initial })
    }
}
