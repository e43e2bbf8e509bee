//! Flags between a worker that may send a command to run and another thread that stops the inverter: whichever comes first, one of
//! them sees the other. Checked by the model checker of `tests/loom`.

use crate::sync::{
    AtomicBool,
    Ordering::{Relaxed, SeqCst},
    fence,
};

/// Flags of an inverter.
#[derive(Debug)]
pub(crate) struct RunFlags {
    /// The inverter may turn.
    may_run: AtomicBool,
    /// A stop was sent without the worker, which has not noticed it yet.
    has_stopped: AtomicBool,
}

impl RunFlags {
    /// Returns the flags of an inverter that stands.
    pub(crate) fn new() -> Self {
        Self { may_run: AtomicBool::new(false), has_stopped: AtomicBool::new(false) }
    }

    /// Notes whether the inverter may turn.
    pub(crate) fn set_may_run(&self, may_run: bool) {
        self.may_run.store(may_run, Relaxed);
    }

    /// Returns whether the inverter may turn.
    pub(crate) fn may_run(&self) -> bool {
        self.may_run.load(Relaxed)
    }

    /// Notes whether the inverter may turn once the next frame has left. Returns whether that frame may leave: not behind a stop
    /// that is not noticed yet.
    pub(crate) fn may_send(&self, may_run: bool) -> bool {
        self.set_may_run(may_run);
        fence(SeqCst); // Pairs with the fence in `begin`: its load sees the store above, or the load below sees its store.
        !self.has_stopped.load(Relaxed)
    }

    /// Begins a stop. Returns whether the inverter may turn.
    pub(crate) fn begin(&self) -> bool {
        self.has_stopped.store(true, Relaxed);
        fence(SeqCst); // Pairs with the fence in `may_send`.
        self.may_run()
    }

    /// Returns whether a stop was sent without the worker, which notices it now.
    pub(crate) fn notice(&self) -> bool {
        self.has_stopped.swap(false, Relaxed)
    }
}
