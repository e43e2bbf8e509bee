//! Work of the control side while it waits: messages, the virtual clock, clients, freeing of
//! memory.

use crate::{Engine, ends, observe::record::Recording, os, realtime::clock};

/// Largest number of instants of machine time that run between two checks of the socket.
const SLICE: u32 = 4096;

impl Engine {
    /// Makes one pass of the control side: messages, faults, the clock, the socket. Waits at most
    /// `ms` milliseconds of wall-clock time when there is nothing to do.
    pub(crate) fn pump(&mut self, ms: i32) {
        if ends::is_claimed() {
            ends::park();
        }
        self.instance.control.beat();
        self.hear();
        // The guard writes as well: what it was refused is reported also while time stands still.
        self.drain_recording();
        let moved = self.advance();
        self.notice_fault();
        self.reap();
        // A reader that empties a full ring sends no notification, so look again soon.
        let ms = if self.probes.have_room() { ms } else { ms.min(1) };
        let ms = if moved { 0 } else { ms };
        crate::serve::server::serve_once(self, ms);
    }

    /// Moves the virtual clock if it may move, or runs the tasks that are due on the real clock.
    /// Returns whether the virtual clock was advanced.
    fn advance(&mut self) -> bool {
        self.measure_ticks();
        let now = self.shared.now();
        if !self.shared.is_virtual() {
            self.tell_overruns(false);
            self.run_tasks(now);
            self.look_while_stopped(now);
            self.refresh_flight();
            self.drain_flight();
            return false;
        }
        let target = self.target.max(self.client_target);
        if now >= target || self.held_back() {
            return false;
        }
        if self.recording.as_ref().is_some_and(Recording::is_waiting) {
            self.begin_recording();
        }
        self.refresh_flight();
        let poll = crate::serve::polls::next_poll(self);
        let mut until = target.min(poll);
        let waits = crate::serve::polls::waits_for_ticket(self);
        let task_answers = waits && !self.tasks.is_empty();
        if until == i64::MAX && self.is_idle() && !task_answers {
            // Without a target the clock does not move while nothing runs: a script that waits for
            // a program before `start` finds the clock unchanged. A command that a task answers
            // still proceeds.
            return false;
        }
        until = until.min(self.next_task());
        // A client or script that waits for a ticket or a ring must see it as soon as it changes.
        let looks = self.script_waits && !self.rings.is_empty();
        let instants = if looks || waits { 1 } else { SLICE };
        clock::turn(&self.shared, &self.probes, until.max(now), instants);
        self.drain_recording();
        self.drain_flight();
        let now = self.shared.now();
        self.run_tasks(now);
        true
    }

    /// Returns whether no function runs: threads are stopped or absent, or a function has failed.
    pub(crate) fn is_idle(&self) -> bool {
        let running = self.shared.boundary.is_running() && self.shared.fault.get().is_none();
        !running || self.shared.threads.load().is_empty()
    }

    /// Moves the virtual clock by one instant of machine time, for a script that waits. Returns
    /// false if the clock did not move and the script must wait itself.
    pub(crate) fn advance_one(&mut self) -> bool {
        let now = self.shared.now();
        if self.held_back() {
            return false;
        }
        if self.shared.mailbox.is_filling() {
            self.hear();
        }
        self.refresh_flight();
        let until = self.next_task().min(crate::serve::polls::next_poll(self));
        let until = until.min(now.saturating_add(1_000_000_000));
        clock::turn(&self.shared, &self.probes, until.max(now), 1);
        self.drain_recording();
        self.drain_flight();
        let then = self.shared.now();
        self.run_tasks(then);
        then > now
    }

    /// Measures the length of a tick of the cycle counter.
    pub(crate) fn measure_ticks(&mut self) {
        let (ticks, ns) =
            (os::ticks().wrapping_sub(self.ticks.0), os::monotonic_ns() - self.ticks.1);
        if ns > 1_000_000 && ticks > 0 && self.shared.tick_ns().to_bits() == 1_f64.to_bits()
            || ns > 100_000_000
        {
            self.shared.set_tick_ns(ns as f64 / ticks as f64);
        }
    }
}
