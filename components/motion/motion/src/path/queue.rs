//! Realtime. The queue of a path: moves come in, go to the planner, and end when the motion has passed them.

use super::{
    AT_REST, KNOWN, Known, Live, Path, Pending, QUEUE_LEN, Stop,
    order::{Item, Kind, Order, PathMove, comes_after},
    retract::Retract,
    spindle::Course,
    sweep::Sweep,
    tracker::Tracker,
};
use crate::commands::{
    command::{Follows, Output, Sync},
    refusal::Refusal,
};
use hal_component::{Pose, TicketHandle};
use hal_trajectory::{Group, Shape, Step};

/// Largest number of moves sent to the planner in a cycle.
const PER_CYCLE: usize = 16;

const BEFORE: Refusal = Refusal::new("a move before this one was refused");

/// Reason for which a probe move fails at its end.
const NO_CONTACT: Refusal = Refusal::new("the probe move ended without a change of the probe");

impl Path {
    /// Appends a move to the pose `to`, in which letters that are NaN stay. `now` is the pose of the machine.
    pub(crate) fn push(
        &mut self,
        now: &Pose,
        to: &Pose,
        mut order: PathMove,
        ticket: Option<TicketHandle>,
    ) -> Result<(), Refusal> {
        self.needs_room()?;
        let start = if self.live == Live::Rest { *now } else { self.end };
        let mut end = start;
        for (place, wanted) in end.iter_mut().zip(to) {
            if wanted.is_infinite() {
                return Err(Refusal::new("a coordinate is infinite"));
            }
            if !wanted.is_nan() {
                *place = *wanted;
            }
        }
        match &mut order.shape {
            Shape::Line { end: e } => e.0 = end,
            Shape::Arc { end: e, center, .. } => {
                e.0 = end;
                for (place, start) in center.iter_mut().zip(&start) {
                    if place.is_nan() {
                        *place = *start;
                    }
                }
            }
        }
        if let Some(Sync { follows: Follows::Place | Follows::Tap { .. }, .. }) = order.sync {
            is_followable(&start, &end)?;
        }
        // A tap ends where it begins.
        let end = if order.is_tap() { start } else { end };
        let (length, turns, circle) = match order.kind {
            Kind::Arc => {
                let sweep = Sweep::new(&start, &order.shape);
                (sweep.length(), sweep.turns(), sweep.circle())
            }
            Kind::None | Kind::Rapid | Kind::Feed | Kind::Probe => (0.0, 0.0, Default::default()),
        };
        if self.live == Live::Rest {
            self.live = Live::Wanted;
            self.base = *now;
        }
        let id = self.new_id();
        if let Some(known) = self.known.get_mut(id as usize % KNOWN) {
            *known = Known {
                id,
                line: order.line,
                kind: order.kind,
                end,
                length,
                turns,
                circle,
                sync: order.sync,
            };
        }
        self.end = end;
        self.pending.push_back(Pending { id, item: Item::Move(order), end, ticket });
        Ok(())
    }

    /// Appends an output that changes when the motion gets there; with nothing before it, in this cycle.
    pub(crate) fn push_output(&mut self, output: Output) -> Result<(), Refusal> {
        self.needs_room()?;
        let id = self.new_id();
        self.pending.push_back(Pending {
            id,
            item: Item::Output(output),
            end: self.end,
            ticket: None,
        });
        Ok(())
    }

    fn needs_room(&self) -> Result<(), Refusal> {
        if matches!(self.stop, Some(Stop::Abort(_))) || self.leaves_hole() {
            return Err(Refusal::new("the machine is still coming to a stop"));
        }
        if self.pending.len() >= QUEUE_LEN {
            return Err(Refusal::new("2000 moves are waiting already"));
        }
        Ok(())
    }

    const fn new_id(&mut self) -> u32 {
        let id = self.next_id;
        self.next_id = if id == u32::MAX { 1 } else { id + 1 };
        id
    }

    /// Takes refusals of the planner: the refused move and all after it end.
    pub(super) fn take_reports(&mut self) {
        while !self.hand.reports.is_empty()
            && let Some(report) = self.hand.reports.pop()
        {
            if report.generation != self.generation {
                continue;
            }
            while let Some(last) = self.pending.back()
                && !comes_after(report.id, last.id)
            {
                if let Some(ticket) = last.ticket {
                    let why = if last.id == report.id { report.why } else { BEFORE };
                    why.fail(ticket);
                }
                self.pending.pop_back();
            }
            self.end = self.pending.back().map_or(self.base, |p| p.end);
            self.sent = self.sent.min(self.pending.len());
            self.resume_due = true;
            self.refused = Some(report.why);
            // Axes that move go on to the end of the moves before it.
            if self.course != Course::Free && !self.last.moving {
                // The next move begins a path of its own.
                self.begin_anew();
                if self.pending.is_empty() {
                    self.leave();
                }
            }
        }
        if self.resume_due {
            let order = Order::Resume { generation: self.generation };
            self.resume_due = self.hand.orders.push(order).is_err();
        }
    }

    /// Sends moves to the planner.
    pub(super) fn send(&mut self) {
        if !matches!(self.live, Live::Asked | Live::Follows)
            || self.stop.is_some()
            || self.resume_due
        {
            return;
        }
        for _ in 0..PER_CYCLE {
            let Some(next) = self.pending.get(self.sent) else { return };
            if let Item::Move(order) = next.item {
                // A thread that has ended does not go on: another one begins at the index.
                let is_over = self.sent == 0 && self.is_bound();
                let is_alone = matches!(self.retract, Retract::Of(id) if id != next.id);
                if is_over || is_alone || Course::of(next.id, order.sync) != self.course {
                    return self.end_course();
                }
                let order = Order::Move { generation: self.generation, id: next.id, order };
                if self.hand.orders.push(order).is_err() {
                    return;
                }
            }
            self.sent += 1;
        }
    }

    /// The next move needs a path of its own: it begins when this one has ended.
    fn end_course(&mut self) {
        if self.sent == 0 {
            if self.live == Live::Follows && !self.last.moving {
                self.begin_anew();
            }
        } else if !self.is_finishing && (self.course != Course::Free || self.retract != Retract::No)
        {
            let order = Order::Finish { generation: self.generation };
            self.is_finishing = self.hand.orders.push(order).is_ok();
        }
    }

    /// Leaves the path, which rests, so that the planner begins another one for the moves that wait.
    pub(super) fn begin_anew(&mut self) {
        let old = self.session.take();
        self.give_back(old);
        self.sent = 0;
        self.resume_due = false;
        self.is_finishing = false;
        self.course = Course::Free;
        self.tracker = Tracker::default();
        self.live = if self.pending.is_empty() { Live::Rest } else { Live::Wanted };
        self.last = Step { pose: self.last.pose, ..AT_REST };
    }

    /// Ends the moves that the motion has passed. Outputs stay until [`Self::due`].
    pub(super) fn end_moves(&mut self, is_at_end: bool) {
        while let Some(front) = self.pending.front() {
            let passed = self.last.line != 0 && comes_after(self.last.line, front.id)
                || is_at_end && self.hand.is_finished(self.generation, front.id);
            let Item::Move(order) = front.item else { return };
            if !passed || order.is_tap() {
                return;
            }
            let missed = order.probe.is_some_and(|p| p.must);
            if let Some(ticket) = front.ticket {
                if missed {
                    ticket.fail(NO_CONTACT.text());
                } else {
                    ticket.done();
                }
            }
            if missed {
                self.failed.get_or_insert(NO_CONTACT);
            }
            self.base = front.end;
            self.pending.pop_front();
            self.sent = self.sent.saturating_sub(1);
        }
    }

    /// Ends the move in progress, which is complete.
    pub(super) fn end_front(&mut self) {
        let Some(front) = self.pending.pop_front() else { return };
        if let Some(ticket) = front.ticket {
            ticket.done();
        }
        self.base = front.end;
        self.sent = self.sent.saturating_sub(1);
    }

    /// Takes the next output that the motion has reached.
    pub(crate) fn due(&mut self) -> Option<Output> {
        let Item::Output(output) = self.pending.front()?.item else { return None };
        self.pending.pop_front();
        self.sent = self.sent.saturating_sub(1);
        Some(output)
    }
}

/// Refuses a move whose longest part is not in x y z, to which a pitch applies.
fn is_followable(start: &Pose, end: &Pose) -> Result<(), Refusal> {
    let by = hal_trajectory::Pose(*end) - hal_trajectory::Pose(*start);
    let [xyz, abc, uvw] = Group::ALL.map(|g| by.norm(g));
    if xyz > 1e-6 && xyz >= abc && xyz >= uvw {
        return Ok(());
    }
    Err(Refusal::new("a move that follows a spindle needs its longest part in x y z"))
}
