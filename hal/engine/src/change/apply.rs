//! Delivery of a change to the threads, their start and stop, and the release of retired data.

use crate::{Engine, Error, graph::Ix};
use hal_protocol::Lock;

impl Engine {
    /// `start`: marks threads to be started at the end of the transaction.
    pub(crate) fn start_threads(&mut self) -> Result<(), Error> {
        self.model.unlocked(Lock::RUN, "start_threads")?;
        // Also if a function failed first, which is then the fault.
        if let Some(worker) = self.workers.failed() {
            return Err(Error::WorkerFailed { worker: worker.as_str().into() });
        }
        let fault = self.runtime.fault();
        if let Some(f) = fault {
            let in_use = self.model.graph().funct_named(f.funct.as_str());
            if in_use.is_some_and(|ix| self.model.graph().is_in_use(ix)) {
                return Err(Error::Faulted { funct: f.funct.as_str().into() });
            }
        }
        let starts = fault.is_some() || !self.runtime.is_running();
        self.model.staged_mut().start(starts);
        Ok(())
    }

    /// Lets threads run. Their lists are already up to date.
    pub(crate) fn run_threads(&mut self) {
        if self.observers.is_recording() {
            self.begin_recording();
        }
        self.refresh_flight();
        let missing = self.runtime.prepare();
        self.notices(missing);
        self.runtime.start();
        self.model.has_run();
    }

    /// Starts the cycles of a thread.
    pub(crate) fn begin_thread(&mut self, ix: Ix) -> Result<(), Error> {
        let thread = self.model.graph().thread(ix).map(|t| t.thread.clone());
        thread.map_or(Ok(()), |thread| self.runtime.begin_thread(&thread, self.model.arena()))
    }

    /// Frees data that no thread uses any more.
    pub(crate) fn reap(&mut self) {
        if self.runtime.has_garbage() {
            // Messages are texts of libraries that may close now.
            self.drain_messages();
            self.runtime.free_garbage();
        }
    }
}
