//! Realtime. The queue of a path: moves come in, go to the planner, and end when the motion has passed them.

use super::{
    KNOWN, Known, Live, Path, Pending, QUEUE_LEN, Stop,
    order::{Item, Kind, Order, PathMove, comes_after},
    sweep::Sweep,
};
use crate::commands::{command::Output, refusal::Refusal};
use hal_component::{Pose, TicketHandle};
use hal_trajectory::Shape;

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
        let (length, turns) = match order.kind {
            Kind::Arc => {
                let sweep = Sweep::new(&start, &order.shape);
                (sweep.length(), sweep.turns())
            }
            Kind::None | Kind::Rapid | Kind::Feed | Kind::Probe => (0.0, 0.0),
        };
        if self.live == Live::Rest {
            self.live = Live::Wanted;
            self.base = *now;
        }
        let id = self.new_id();
        if let Some(known) = self.known.get_mut(id as usize % KNOWN) {
            *known = Known { id, line: order.line, kind: order.kind, end, length, turns };
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
        if matches!(self.stop, Some(Stop::Abort(_))) {
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
        while let Some(report) = self.hand.reports.pop() {
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
                let order = Order::Move { generation: self.generation, id: next.id, order };
                if self.hand.orders.push(order).is_err() {
                    return;
                }
            }
            self.sent += 1;
        }
    }

    /// Ends the moves that the motion has passed. Outputs stay until [`Self::due`].
    pub(super) fn end_moves(&mut self, is_at_end: bool) {
        while let Some(front) = self.pending.front() {
            let passed = self.last.line != 0 && comes_after(self.last.line, front.id)
                || is_at_end && self.hand.is_finished(self.generation, front.id);
            let Item::Move(order) = front.item else { return };
            if !passed {
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

    /// Takes the next output that the motion has reached.
    pub(crate) fn due(&mut self) -> Option<Output> {
        let Item::Output(output) = self.pending.front()?.item else { return None };
        self.pending.pop_front();
        self.sent = self.sent.saturating_sub(1);
        Some(output)
    }
}
