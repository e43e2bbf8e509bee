//! Snapshots: plain records that programs read from shared memory.

use crate::{
    Builder, Error, Plain, Touch, Uses,
    abi::{self, PageReader, PageWriter, SnapshotRef, SnapshotSpec, Status, Str},
    builder::check,
    exchange::{fill, fill_some},
};
use core::marker::PhantomData;

/// Largest number of attempts to copy a record while its writer replaces it.
const ATTEMPTS: u32 = 10_000;

/// Writing end of a snapshot. Programs read the latest record, always as a whole; they cannot delay
/// or change it.
#[derive(Debug)]
pub struct Snapshot<T> {
    page: PageWriter,
    kind: PhantomData<fn(T)>,
}

impl<T: Plain> Snapshot<T> {
    /// Realtime. Publishes a record in the place of the last one.
    #[inline]
    pub fn set(&mut self, value: &T) {
        self.page.put(|words| fill(words, value));
    }

    /// Realtime. Publishes a record of which only the fields in `FIELDS`, made by [`fields`](crate::fields), may differ
    /// from the last one: the words of all others stay.
    #[inline]
    pub fn set_some<const FIELDS: u128>(&mut self, value: &T) {
        self.page.put(|words| fill_some::<FIELDS, T>(words, value));
    }

    /// Returns a reading end of the same snapshot.
    #[must_use]
    pub fn reader(&self) -> SnapshotReader<T> {
        SnapshotReader { page: self.page.reader(), kind: PhantomData }
    }
}

/// Reading end of a snapshot, for other parts of the same component.
#[derive(Debug)]
pub struct SnapshotReader<T> {
    page: PageReader,
    kind: PhantomData<fn() -> T>,
}

impl<T: Plain> SnapshotReader<T> {
    /// Returns the latest record, as a whole. Not for realtime: it tries again while the writer
    /// replaces the record. Before the first record all its words are zero. Returns `None` if the
    /// writer has stopped in the middle of a record.
    #[must_use]
    pub fn get(&self) -> Option<T> {
        let mut words = vec![0; T::WORDS];
        for _ in 0..ATTEMPTS {
            let copied = self.page.copy(|n, bits| {
                if let Some(word) = words.get_mut(n) {
                    *word = bits;
                }
            });
            if copied.is_some() {
                let mut words = words.into_iter();
                return Some(T::load(&mut || words.next().unwrap_or(0)));
            }
            std::thread::yield_now();
        }
        None
    }
}

impl<T> Touch for SnapshotReader<T> {
    fn touch(&self, _: &mut Uses) {}
}

impl<T> Touch for Snapshot<T> {
    fn touch(&self, _: &mut Uses) {}
}

impl Builder<'_> {
    /// Creates a snapshot, which one function, task or worker of this component writes. The name is
    /// absolute, such as `motion.status`. The version changes when a field changes or is removed.
    ///
    /// ```
    /// use hal_component::{Builder, Error, Period, Plain, Snapshot, Touch, Update};
    ///
    /// #[derive(Clone, Copy, Plain)]
    /// struct Status {
    ///     /// Number of cycles.
    ///     cycles: u64,
    ///     /// Positions of the joints in machine units.
    ///     position: [f64; 3],
    /// }
    ///
    /// #[derive(Touch)]
    /// struct Controller {
    ///     status: Snapshot<Status>,
    ///     #[state]
    ///     cycles: u64,
    /// }
    /// impl Update for Controller {
    ///     fn update(&mut self, _: Period) {
    ///         self.cycles += 1;
    ///         self.status.set(&Status { cycles: self.cycles, position: [0.0; 3] });
    ///     }
    /// }
    ///
    /// fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    ///     let status = b.snapshot("robot.status", 1, "State of the robot in each cycle.")?;
    ///     b.function("update", "Moves", Controller { status, cycles: 0 })
    /// }
    /// ```
    ///
    /// # Errors
    /// The name is taken or too long, the record has no fields or too many, or the engine is out of
    /// memory.
    pub fn snapshot<T: Plain>(
        &mut self,
        name: &str,
        version: u32,
        doc: &str,
    ) -> Result<Snapshot<T>, Error> {
        let spec = SnapshotSpec {
            size: abi::size::<SnapshotSpec>(),
            version,
            name: Str::borrow(name),
            doc: Str::borrow(doc),
            fields: abi::List::new(T::FIELDS),
        };
        let mut out = SnapshotRef { page: core::ptr::null(), words: 0 };
        let snapshot = self.host.snapshot.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: this is the engine's function; `spec` and `out` live for the duration of the
        // call.
        check(unsafe { snapshot(self.host.ctx, &raw const spec, &raw mut out) })?;
        if out.page.is_null() || out.words as usize != T::WORDS {
            return Err(Error::engine(Status::ENOMEM));
        }
        // SAFETY: the engine created the page with this number of words for this component alone.
        let page = unsafe { PageWriter::new(out.page, out.words) };
        Ok(Snapshot { page, kind: PhantomData })
    }
}
