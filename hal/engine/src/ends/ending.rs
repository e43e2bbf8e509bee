//! Orderly shutdown of an instance: outputs first, then recordings, programs, components, the
//! socket.

use crate::{Engine, realtime::runtime::TIMEOUT_NS};

/// Time that the outputs wait for a cycle in progress when an instance ends, in nanoseconds.
const OUTPUTS_NS: i64 = 50_000_000;

impl Engine {
    /// Stops the threads, runs every stop action, ends programs, unloads everything and releases
    /// the socket.
    pub fn close(mut self) {
        self.end();
    }

    /// Closes the instance as [`Self::close`] does. Returns false if a function had failed, if a
    /// thread did not leave its function, if a worker did not return, or if a recording or the file
    /// of an event could not be written whole.
    #[must_use]
    pub fn close_checked(mut self) -> bool {
        self.end()
    }

    fn end(&mut self) -> bool {
        // Outputs first, even if a cycle takes long.
        let prompt = self.runtime.stop_within(OUTPUTS_NS);
        let failed = self.runtime.shared().fault.get().is_some();
        self.run_stops(&self.model.graph().components_by_age());
        if !prompt {
            match self.runtime.settle() {
                // The cycle in progress may have written once more.
                Ok(()) => self.run_stops(&self.model.graph().components_by_age()),
                // No later step waits for that thread again.
                Err(_) => self.runtime.wait_no_more(),
            }
        }
        // Outputs are safe, so a slow disk has time for the rest.
        self.runtime.instance().control.be_patient();
        if self.observers.is_recording()
            && let Err(e) = self.end_recording()
        {
            self.notice(e.to_string());
        }
        if self.observers.is_flight_on()
            && let Err(e) = self.end_flight()
        {
            self.notice(e.to_string());
        }
        self.runtime.instance().control.have_waited();
        self.clients.end_programs(self.runtime.instance());
        let clean = self.runtime.quit();
        self.runtime.control().be_patient();
        let busy = self.workers.end(TIMEOUT_NS);
        self.runtime.control().have_waited();
        let idle = busy.is_empty();
        busy.iter().for_each(|e| self.notice(e.to_string()));
        let late = self.runtime.overruns(self.model.graph(), true);
        self.notices(late);
        if clean && idle {
            self.free_all();
        } else {
            // A thread that never leaves its function, or a worker that does not return, still uses
            // all of this.
            if !clean {
                let stuck = self.runtime.stuck();
                self.notice(stuck.to_string());
            }
            self.runtime.leak();
            self.snapshots.leak();
            self.model.leak();
        }
        self.drain_messages();
        self.log.end_joins(None);
        self.runtime.instance().leave();
        self.clients.close();
        clean && idle && !failed && !self.observers.is_unwritten()
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        if !self.runtime.has_quit() {
            self.end();
        }
    }
}
