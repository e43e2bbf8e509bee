//! Realtime. Pause, single steps and reverse motion; aborts; and a new plan for the rest of a path when limits change.

use super::{
    AT_REST, Live, Parked, Path, Stop, order::Item, retract::Retract, spindle::Course, sweep,
    tracker::Tracker,
};
use crate::commands::{command::Run, refusal::Refusal};
use hal_component::Pose;
use hal_trajectory::Scales;
use libm::fabs;

/// Distance from the end of a move that is rounding, in units and relative to a coordinate.
const AT_END: f64 = 1e-9;

const ABORTED: Refusal = Refusal::new("aborted");
const LOWERED: Refusal = Refusal::new("a limit became tighter while the axes followed a spindle");
const PROBED: Refusal = Refusal::new("the path ended where the probe changed");
const TRIPPED: Refusal = Refusal::new("the probe is tripped already as the probe move begins");
const RELEASED: Refusal = Refusal::new("the probe is not tripped as the probe move begins");

impl Path {
    /// Refuses a probe move that would begin in this cycle although the probe is already as it would be at its end. Nothing has
    /// moved for it.
    pub(super) fn refuse_probe(&mut self, probe: bool, scales: &Scales) {
        if !self.last.rests || self.stop.is_some() {
            return;
        }
        let mut moves = self.pending.iter().filter_map(|pending| match &pending.item {
            Item::Move(order) => Some((pending, order)),
            Item::Output(_) => None,
        });
        let Some((front, first)) = moves.next() else { return };
        let has_begun = front.id == self.last.line && self.travelled != 0.0;
        let is_over = has_begun && self.rests_at(&front.end);
        let next = if is_over { moves.next() } else { Some((front, first)) };
        let Some((id, order)) = next.filter(|_| is_over || !has_begun).map(|(p, o)| (p.id, o))
        else {
            return;
        };
        let Some(wanted) = order.probe.filter(|_| order.kind.scale(scales) != 0.0) else { return };
        self.probe_begun = id;
        if probe == wanted.away {
            return;
        }
        if is_over {
            self.end_front();
        }
        let why = if wanted.away { RELEASED } else { TRIPPED };
        self.failed.get_or_insert(why);
        self.abort_with(why);
    }

    /// Returns whether the motion is at a pose but for rounding.
    fn rests_at(&self, end: &Pose) -> bool {
        let is_near = |(a, b): (&f64, &f64)| fabs(a - b) <= AT_END * (1.0 + fabs(*b));
        end.iter().zip(&self.last.pose.0).all(is_near)
    }

    /// Stops a probe move where the probe changes.
    pub(super) fn watch_probe(&mut self, probe: bool) {
        let Some(front) = self.pending.front().filter(|f| f.id == self.last.line) else { return };
        let Item::Move(order) = front.item else { return };
        let Some(wanted) = order.probe else { return };
        if self.stop.is_some() || !self.last.moving {
            return;
        }
        let has_changed = probe != wanted.away;
        let is_first = self.probe_begun != front.id;
        self.probe_begun = front.id;
        if has_changed && is_first {
            let why = if wanted.away { RELEASED } else { TRIPPED };
            self.failed.get_or_insert(why);
            self.abort_with(why);
        } else if has_changed {
            self.probed = true;
            self.stop = Some(Stop::Probed);
        }
    }

    /// Returns once that a probe move has found its place: in the cycle in which it did.
    pub(crate) fn take_probed(&mut self) -> bool {
        core::mem::take(&mut self.probed)
    }

    /// Returns whether a probe move is in progress.
    pub(crate) fn is_probing(&self) -> bool {
        self.current().is_some_and(|c| c.kind == super::order::Kind::Probe)
    }

    /// Takes the reason for which the path failed.
    pub(crate) const fn take_failed(&mut self) -> Option<Refusal> {
        self.failed.take()
    }

    /// Ends a pause after the few cycles in which the axes close the deadband of their jog.
    pub(crate) const fn resume_soon(&mut self) {
        self.resume_in = 4;
    }

    /// Brakes, and rests.
    pub(crate) const fn pause(&mut self) {
        self.paused = true;
        self.step_of = None;
    }

    /// Pauses, resumes, steps or reverses.
    pub(crate) fn run(&mut self, run: Run) -> Result<(), Refusal> {
        match run {
            Run::Pause => self.pause(),
            Run::Resume => {
                self.paused = false;
                self.step_of = None;
            }
            Run::Step if self.pending.is_empty() => {
                return Err(Refusal::new("no move waits that a step could begin"));
            }
            Run::Step => {
                self.paused = false;
                // Before the first move begins, a step is that move.
                let first = self.pending.front().map_or(0, |p| p.id);
                self.step_of = Some(if self.last.line == 0 { first } else { self.last.line });
            }
            Run::Reverse if self.session.is_none() => {
                return Err(Refusal::new("there is no path to go back along"));
            }
            Run::Reverse => self.reverse = true,
            Run::Forward => self.reverse = false,
        }
        Ok(())
    }

    /// Brakes along the path and discards the remaining moves.
    /// A tap follows its spindle out of the hole first; the result is that spindle.
    pub(crate) fn abort(&mut self) -> Option<usize> {
        let tapping = self.abort_tap(ABORTED);
        if tapping.is_none() {
            self.abort_with(ABORTED);
        }
        tapping
    }

    /// Brakes along the path and discards the remaining moves, for a reason.
    pub(crate) fn abort_with(&mut self, why: Refusal) {
        while self.pending.len() > 1 {
            if let Some(ticket) = self.pending.pop_back().and_then(|p| p.ticket) {
                why.fail(ticket);
            }
        }
        self.sent = self.sent.min(1);
        if self.session.is_none() || !self.last.moving {
            self.clear(why);
        } else {
            self.stop = Some(Stop::Abort(why));
        }
    }

    /// Ends the path at once.
    pub(crate) fn clear(&mut self, why: Refusal) {
        for ticket in self.pending.drain(..).filter_map(|p| p.ticket) {
            why.fail(ticket);
        }
        self.leave();
    }

    /// Leaves a path that has ended, so that the next move begins where the machine is then.
    pub(crate) fn leave(&mut self) {
        if self.live != Live::Rest {
            self.generation = self.generation.wrapping_add(1);
            self.hand.set_latest(self.generation);
        }
        let old = self.session.take();
        self.give_back(old);
        self.live = Live::Rest;
        self.sent = 0;
        self.resume_due = false;
        self.stop = None;
        self.paused = false;
        self.parked = Parked::No;
        self.resume_in = 0;
        self.reverse = false;
        self.step_of = None;
        self.last = AT_REST;
        self.velocity = 0.0;
        self.is_finishing = false;
        self.course = Course::Free;
        self.tracker = Tracker::default();
        self.retract = Retract::No;
    }

    /// Plans the rest of the path again for limits that have changed. A path that has ended is left.
    pub(crate) fn replan(&mut self) {
        if self.is_idle() {
            if self.live != Live::Rest {
                self.leave();
            }
        } else if self.is_bound() {
            if self.abort_tap(LOWERED).is_none() && !self.leaves_hole() {
                self.abort_with(LOWERED);
            }
        } else if self.stop.is_none() && self.live != Live::Wanted {
            self.stop = Some(Stop::Replan);
            if self.session.is_none() {
                self.end_stop();
            }
        }
    }

    /// Pauses once a single step has reached the next move.
    pub(super) fn end_step(&mut self) {
        let line = self.last.line;
        if self.step_of.is_some_and(|of| line != of && line != 0) {
            self.step_of = None;
            self.paused = true;
        }
    }

    /// At rest: completes a stop.
    pub(super) fn end_stop(&mut self) {
        match self.stop.take() {
            None => {}
            Some(Stop::Abort(why)) => self.clear(why),
            Some(Stop::Probed) => {
                if let Some(ticket) = self.pending.pop_front().and_then(|p| p.ticket) {
                    ticket.done();
                }
                self.clear(PROBED);
            }
            Some(Stop::Replan) => {
                self.cut_front();
                self.begin_anew();
            }
        }
    }

    /// Replaces the move in progress by what is left of it.
    fn cut_front(&mut self) {
        let Some(known) = self.known(self.last.line).copied() else { return };
        let Some(front) = self.pending.front_mut().filter(|f| f.id == known.id) else { return };
        let Item::Move(order) = &mut front.item else { return };
        if known.length > 0.0 {
            let left = 1.0 - self.travelled / known.length;
            let left = if left > 0.0 { left } else { 0.0 };
            order.shape = sweep::rest(&order.shape, &self.last.pose.0, known.turns * left);
        }
    }
}
