//! Orderly shutdown of an instance: outputs first, then recordings, programs, components, the
//! socket.

use crate::{Engine, change::apply::TIMEOUT_NS, os, sync::Ordering};

/// Time that the outputs wait for a cycle in progress when an instance ends, in nanoseconds.
const OUTPUTS_NS: i64 = 50_000_000;

impl Engine {
    /// Stops the threads, runs every stop action, ends programs, unloads everything and releases
    /// the socket.
    pub fn close(mut self) {
        self.end();
    }

    /// Closes the instance as [`Self::close`] does. Returns false if a function had failed, if a thread
    /// did not leave its function, or if a recording or the file of an event could not be written
    /// whole.
    #[must_use]
    pub fn close_checked(mut self) -> bool {
        self.end()
    }

    fn end(&mut self) -> bool {
        self.shared.boundary.stop();
        // Outputs first, even if a cycle takes long.
        let limit = core::mem::replace(&mut self.settle_ns, OUTPUTS_NS);
        let prompt = self.settle().is_ok();
        self.settle_ns = limit;
        let failed = self.shared.fault.get().is_some();
        self.run_stops(&self.graph.components_by_age());
        if !prompt {
            match self.settle() {
                // The cycle in progress may have written once more.
                Ok(()) => self.run_stops(&self.graph.components_by_age()),
                // No later step waits for that thread again.
                Err(_) => self.settle_ns = 0,
            }
        }
        if self.recording.is_some()
            && let Err(e) = self.end_recording()
        {
            self.notice(e.to_string());
        }
        if self.flight.is_some()
            && let Err(e) = self.end_flight()
        {
            self.notice(e.to_string());
        }
        self.end_programs();
        self.shared.quit.store(true, Ordering::Relaxed);
        self.watchdog = None;
        self.instance.control.be_patient();
        let clean = self.runners.end(&[], true, self.settle_ns);
        self.instance.control.have_waited();
        // Up to here, if a stuck function returns, the outputs are driven to their safe levels
        // again.
        self.end_realtime();
        if clean {
            for ix in self.graph.components_by_age().into_iter().rev() {
                self.remove_component(ix);
            }
            self.reap();
        } else {
            // A thread that never leaves its function still uses all of this.
            let stuck = self.stuck();
            self.notice(stuck.to_string());
            let _left = core::mem::ManuallyDrop::new((
                core::mem::take(&mut self.retired),
                core::mem::take(&mut self.graph),
                core::mem::take(&mut self.rings),
            ));
            self.arena.leave();
        }
        self.hear();
        self.end_joins(None);
        self.instance.leave();
        self.server = None;
        clean && !failed && !self.unwritten
    }

    fn end_programs(&mut self) {
        self.instance.control.be_patient();
        for p in &self.programs {
            os::end_process(p.pid, false);
        }
        let limit = os::monotonic_ns() + TIMEOUT_NS;
        while self.programs.iter().any(|p| os::alive(p.pid)) && os::monotonic_ns() < limit {
            if let Some(server) = &mut self.server {
                server.drop_clients();
            }
            os::sleep_until(os::monotonic_ns() + 2_000_000);
        }
        for p in &self.programs {
            if os::alive(p.pid) {
                os::end_process(p.pid, true);
            }
        }
        self.programs.clear();
        self.programs_have_changed();
        self.instance.control.have_waited();
    }

    /// Publishes the list of running programs after it has changed.
    pub(crate) fn programs_have_changed(&self) {
        self.instance.set_programs(self.programs.iter().map(|p| p.pid).collect());
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        if !self.shared.quit.load(Ordering::Relaxed) {
            self.end();
        }
    }
}
