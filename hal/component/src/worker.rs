//! Workers: work that may take long, such as planning or reading a file.

use crate::{
    Builder, Error, Touch,
    abi::{self, Status, Str, WorkerSpec},
    builder::check,
    shim,
};

/// Work that may take long, and that never runs in a realtime thread.
///
/// On the real clock each worker has an ordinary thread of its own, where it may wait for files and
/// devices. On the virtual clock it makes one step at each multiple of its period while time stands
/// still, so what it does must depend only on what it reads from the component. A worker that
/// panics stops motion. It exchanges data with functions through rings, seqlocks, queues and
/// atomics.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no `Work`: a worker needs code to run",
    label = "write `impl Work for {Self} {{ fn work(&mut self, items: u32) -> u32 {{ … }} }}`"
)]
pub trait Work: Touch + Send + 'static {
    /// Does at most `items` items of work, and returns how many it did. If it did all of them, there
    /// may be more: on the real clock the next step then follows at once. Only this count limits a
    /// step, never a reading of a clock.
    fn work(&mut self, items: u32) -> u32;
}

impl Builder<'_> {
    /// Declares a worker, which makes a step of at most `items` items in every `period_ns` of
    /// machine time.
    ///
    /// ```
    /// use hal_component::{Builder, Error, Plain, RingWriter, Touch, Work};
    ///
    /// #[derive(Clone, Copy, Plain)]
    /// struct Point {
    ///     /// Position in machine units.
    ///     position: f64,
    /// }
    ///
    /// /// Keeps the ring full.
    /// #[derive(Touch)]
    /// struct Planner {
    ///     points: RingWriter<Point>,
    ///     #[state]
    ///     next: f64,
    /// }
    ///
    /// impl Work for Planner {
    ///     fn work(&mut self, items: u32) -> u32 {
    ///         for done in 0..items {
    ///             if self.points.put(Point { position: self.next }).is_err() {
    ///                 return done;
    ///             }
    ///             self.next += 1.0;
    ///         }
    ///         items
    ///     }
    /// }
    ///
    /// fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    ///     let (points, _reader) = b.ring(1000);
    ///     b.worker("plan", "Computes points ahead", 10_000_000, 100, Planner { points, next: 0.0 })
    /// }
    /// ```
    ///
    /// # Errors
    /// The name is taken or too long, or the period or the number of items is not positive.
    pub fn worker<F: Work>(
        &mut self,
        name: &str,
        doc: &str,
        period_ns: i64,
        items: u32,
        f: F,
    ) -> Result<(), Error> {
        let name = self.full(name);
        let uses = self.uses(&f);
        let worker = self.host.worker.ok_or(Error::engine(Status::EINVAL))?;
        let spec = WorkerSpec {
            size: abi::size::<WorkerSpec>(),
            flags: 0,
            name: Str::borrow(&name),
            doc: Str::borrow(doc),
            period_ns,
            run: Some(shim::work::<F>),
            state: shim::give(shim::Running::new(f, self.calls())),
            free: Some(shim::free::<shim::Running<F>>),
            uses: uses.as_ptr(),
            n_uses: uses.len(),
            items,
        };
        // SAFETY: this is the engine's function; ownership of the state passes with the call.
        check(unsafe { worker(self.host.ctx, &raw const spec) })
    }
}
