//! What the control side does while it waits: it hears, turns the clock, serves, frees.

use crate::{
    Engine, clock, ends,
    name::Name,
    os,
    record::Recording,
    shared::{Message, Spoken},
    sync::Ordering,
};
use hal_abi::level;

/// How many instants of machine time are run between looks at the socket.
const SLICE: u32 = 4096;

impl Engine {
    /// One turn of the control side: messages, faults, the clock, the socket. Waits at most
    /// `ms` on the wall when there is nothing to do.
    pub(crate) fn pump(&mut self, ms: i32) {
        if ends::is_claimed() {
            ends::park();
        }
        self.instance.control.beat();
        self.hear();
        let moved = self.advance();
        self.notice_fault();
        self.reap();
        // Whoever reads a full ring does not say so.
        let ms = if self.probes.have_room() { ms } else { ms.min(1) };
        let ms = if moved { 0 } else { ms };
        crate::server::serve_once(self, ms);
    }

    /// Moves the virtual clock where it may, or runs the tasks that are due on the real one.
    fn advance(&mut self) -> bool {
        self.measure_ticks();
        let now = self.shared.now();
        if !self.shared.is_virtual() {
            self.tell_overruns(false);
            self.run_tasks(now);
            self.look_while_stopped(now);
            self.drain_recording();
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
        let poll = crate::polls::next_poll(self);
        let mut until = target.min(poll);
        let waits = crate::polls::waits_for_ticket(self);
        let task_answers = waits && !self.tasks.is_empty();
        if until == i64::MAX && self.is_idle() && !task_answers {
            // Without an end nothing moves while nothing runs: a script that waits for a program
            // before `start` finds the clock where it was. A command that a task answers goes on.
            return false;
        }
        until = until.min(self.next_task());
        // Whoever waits for a ticket or a ring is to see it as soon as it changes.
        let looks = self.script_waits && !self.rings.is_empty();
        let instants = if looks || waits { 1 } else { SLICE };
        clock::turn(&self.shared, &self.probes, until.max(now), instants);
        self.drain_recording();
        self.drain_flight();
        let now = self.shared.now();
        self.run_tasks(now);
        true
    }

    /// Whether no function runs, whatever the time.
    pub(crate) fn is_idle(&self) -> bool {
        let running = self.shared.boundary.is_running() && self.shared.fault.get().is_none();
        !running || self.shared.threads.load().is_empty()
    }

    /// Moves the virtual clock by one instant of machine time, for a script that waits; false when
    /// it must wait itself.
    pub(crate) fn advance_one(&mut self) -> bool {
        let now = self.shared.now();
        if self.held_back() {
            return false;
        }
        self.refresh_flight();
        let until = self.next_task().min(crate::polls::next_poll(self));
        let until = until.min(now.saturating_add(1_000_000_000));
        clock::turn(&self.shared, &self.probes, until.max(now), 1);
        self.drain_recording();
        self.drain_flight();
        let then = self.shared.now();
        self.run_tasks(then);
        then > now
    }

    /// Learns how long a tick of the cycle counter is.
    pub(crate) fn measure_ticks(&mut self) {
        let (ticks, ns) =
            (os::ticks().wrapping_sub(self.ticks.0), os::monotonic_ns() - self.ticks.1);
        if ns > 1_000_000 && ticks > 0 && self.shared.tick_ns().to_bits() == 1_f64.to_bits()
            || ns > 100_000_000
        {
            self.shared.set_tick_ns(ns as f64 / ticks as f64);
        }
    }

    /// Logs something of the engine's own.
    pub(crate) fn notice(&mut self, text: String) {
        tracing::warn!("{text}");
        self.keep_message(text);
    }

    fn keep_message(&mut self, text: String) {
        if self.messages.len() >= 1000 {
            self.messages.pop_front();
        }
        self.messages.push_back(text);
    }

    /// Logs what components have said.
    pub(crate) fn hear(&mut self) {
        while let Some(m) = self.shared.heard() {
            let text = self.with_wiring(&worded(&m, self.speaker(m.component)));
            match m.level {
                level::ERR => tracing::error!("{text}"),
                level::WARN => tracing::warn!("{text}"),
                level::INFO => tracing::info!("{text}"),
                _ => tracing::debug!("{text}"),
            }
            self.keep_message(text);
        }
        while let Some(m) = self.shared.heard_text() {
            let text = spoken(&m, self.speaker(m.component));
            match m.level {
                level::ERR => tracing::error!("{text}"),
                level::WARN => tracing::warn!("{text}"),
                0 | level::INFO => tracing::info!("{text}"),
                _ => tracing::debug!("{text}"),
            }
            self.keep_message(text);
        }
        let lost = self.shared.lost_messages.swap(0, Ordering::Relaxed);
        if lost > 0 {
            self.notice(format!("{lost} messages of components were lost: too many at once"));
        }
    }

    fn speaker(&self, component: u32) -> &str {
        let components = self.graph.components.values().chain(&self.left);
        components
            .filter_map(|ix| self.graph.component(*ix))
            .find(|c| c.id == component)
            .map(|c| &c.name)
            .or_else(|| self.gone.as_ref().filter(|(id, _)| *id == component).map(|(_, n)| n))
            .map_or("?", Name::as_str)
    }
}

/// A text with each `{}` replaced by the next number.
pub(crate) fn filled(text: &str, numbers: &[f64]) -> String {
    numbers.iter().fold(text.to_owned(), |s, x| s.replacen("{}", &x.to_string(), 1))
}

/// A message as it is shown, after its speaker's name.
pub(crate) fn worded(m: &Message, speaker: &str) -> String {
    // SAFETY: static in a library that is open: messages are heard before one is closed.
    let text = unsafe { m.text.get() }.unwrap_or("?");
    let said = filled(text, m.numbers.get(..m.n).unwrap_or_default());
    format!("{speaker}: {said}")
}

/// The same of a text.
pub(crate) fn spoken(m: &Spoken, speaker: &str) -> String {
    format!("{speaker}: {}", String::from_utf8_lossy(m.bytes()).trim_end())
}
