//! Work of the control side while it waits: messages, the virtual clock, clients, freeing of
//! memory.

use crate::{Ended, Engine, ends, os, realtime::clock, realtime::shared::MAX_TIME_NS};

/// Largest number of instants of machine time that run between two checks of the socket.
const SLICE: u32 = 4096;
/// Interval in milliseconds at which a paced clock moves.
const PACE_MS: i32 = 5;

impl Engine {
    /// Serves clients until an [`Ended`] condition holds; `for_ns` limits machine time.
    pub fn serve(&mut self, for_ns: Option<u64>) -> Ended {
        self.serve_with(for_ns, &mut |_| {})
    }

    /// Serves clients as [`Self::serve`] does, and calls a function in each pass, at least ten times in a second of a
    /// control side that is not held up.
    pub fn serve_with(&mut self, for_ns: Option<u64>, pass: &mut dyn FnMut(&mut Self)) -> Ended {
        let limit = for_ns
            .map(|ns| self.runtime.now().saturating_add(i64::try_from(ns).unwrap_or(i64::MAX)))
            .map(|limit| limit.min(MAX_TIME_NS));
        let before = self.clients.target;
        let began = (os::monotonic_ns(), self.runtime.now());
        let ended = loop {
            if self.clients.shutdown {
                break Ended::Shutdown;
            }
            if ends::is_asked() {
                break Ended::Signal;
            }
            if limit.is_some_and(|l| self.runtime.now() >= l) {
                break Ended::Time;
            }
            if self.model.graph().threads.is_empty() && limit.is_none() {
                break Ended::NoThreads;
            }
            self.clients.target = match limit {
                Some(l) => l,
                None if self.options.hold => self.clients.target,
                None => i64::MAX,
            };
            let mut most_ms = 100;
            if let Some(pace) = self.options.pace {
                let passed = (os::monotonic_ns() - began.0) as f64 * pace;
                #[expect(clippy::cast_possible_truncation, reason = "a conversion saturates")]
                let due = began.1.saturating_add(passed as i64);
                self.clients.target = self.clients.target.min(due);
                most_ms = PACE_MS;
            }
            let left = limit.map_or(100, |l| (l - self.runtime.now()) / 1_000_000 + 1);
            self.pump(i32::try_from(left).unwrap_or(most_ms).min(most_ms));
            pass(self);
        };
        self.clients.target = before.min(self.runtime.now());
        ended
    }

    /// Makes one pass of the control side: messages, faults, the clock, the socket. Waits at most
    /// `ms` milliseconds of wall-clock time when there is nothing to do.
    pub(crate) fn pump(&mut self, ms: i32) {
        if ends::is_claimed() {
            ends::park();
        }
        self.runtime.control().beat();
        self.drain_messages();
        // The guard writes as well: what it was refused is reported also while time stands still.
        self.drain_recording();
        self.forget_ended_programs();
        let moved = self.advance();
        self.notice_fault();
        self.reap();
        // A reader that empties a full ring sends no notification, so look again soon.
        let ms = if self.observers.probes().have_room() { ms } else { ms.min(1) };
        let ms = if moved { 0 } else { ms };
        crate::serve::turn::serve_once(self, ms);
    }

    /// Moves the virtual clock if it may move, or runs the tasks that are due on the real clock.
    /// Returns whether the virtual clock was advanced.
    fn advance(&mut self) -> bool {
        self.runtime.measure_ticks();
        let now = self.runtime.now();
        if !self.runtime.is_virtual() {
            let late = self.runtime.overruns(self.model.graph(), false);
            self.notices(late);
            let gaps = self.runtime.gaps();
            self.notices(gaps);
            let failed = self.runtime.run_tasks(now);
            self.notices(failed);
            self.answer_workers();
            self.look_while_stopped(now);
            self.refresh_flight();
            self.drain_flight();
            return false;
        }
        let target = self.clients.target.max(self.clients.client_target);
        if now >= target || self.held_back() {
            return false;
        }
        self.take_pages();
        if self.observers.recording_waits() {
            self.begin_recording();
        }
        self.refresh_flight();
        let poll = crate::serve::polls::next_poll(self);
        let until = target.min(poll);
        let waits = crate::serve::polls::waits_for_ticket(self);
        let task_answers = waits && (self.runtime.has_tasks() || !self.workers.is_empty());
        if until == i64::MAX && self.runtime.is_idle() && !task_answers {
            // Without a target the clock does not move while nothing runs: a script that waits for
            // a program before `start` finds the clock unchanged. A command that a task answers
            // still proceeds.
            return false;
        }
        // A client or script that waits for a ticket or a ring must see it as soon as it changes.
        let looks = self.clients.script_waits && !self.model.rings().is_empty();
        let instants = if looks || waits { 1 } else { SLICE };
        self.turn(until, instants);
        true
    }

    /// Runs the virtual clock up to `until` or to the next task or worker, for at most `instants`
    /// instants, and then the tasks and workers that are due.
    fn turn(&mut self, until: i64, instants: u32) {
        let until = until.min(self.runtime.next_task()).min(self.workers.next_due());
        let until = until.max(self.runtime.now());
        clock::turn(self.runtime.shared(), self.observers.probes(), until, instants);
        self.drain_recording();
        self.drain_flight();
        let now = self.runtime.now();
        let failed = self.runtime.run_tasks(now);
        self.notices(failed);
        self.workers.run_due(now, self.runtime.control());
        self.answer_workers();
    }

    /// Answers the workers that ask for values.
    fn answer_workers(&self) {
        self.runtime.shared().questions.answer(|name| self.model.number(name));
    }

    /// Moves the virtual clock by one instant of machine time, for a script that waits. Returns
    /// false if the clock did not move and the script must wait itself.
    pub(crate) fn advance_one(&mut self) -> bool {
        let now = self.runtime.now();
        self.forget_ended_programs();
        if self.held_back() {
            return false;
        }
        self.take_pages();
        if self.runtime.shared().mailbox.is_filling() {
            self.drain_messages();
        }
        self.refresh_flight();
        let poll = crate::serve::polls::next_poll(self);
        self.turn(poll.min(now.saturating_add(1_000_000_000)), 1);
        self.runtime.now() > now
    }
}
