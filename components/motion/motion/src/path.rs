//! Realtime. The current coordinated move, and the queue behind it.

pub(crate) mod line;
pub(crate) mod planner;

use crate::{
    commands::refusal::Refusal,
    path::line::{Line, Machine, MoveRequest},
    path::planner::SimpleTp,
};
use hal_component::{Pose, TicketHandle};
use std::collections::VecDeque;

/// Capacity of the move queue.
pub(crate) const QUEUE_LEN: usize = 200;

/// A queued move.
#[derive(Clone, Copy, Debug)]
struct Segment {
    end: Pose,
    request: MoveRequest,
    ticket: TicketHandle,
}

/// A path of straight moves with a stop at the end of each.
#[derive(Debug)]
pub(crate) struct Path {
    waiting: VecDeque<Segment>,
    current: Option<(Line, TicketHandle)>,
    /// Planner along the current move.
    tp: SimpleTp,
    /// True while braking to abort the path.
    stopping: bool,
    /// True if a move was in progress in the last cycle.
    moved: bool,
    /// Distance along the move at the start of that cycle.
    from: f64,
}

impl Path {
    pub(crate) fn new() -> Self {
        Self {
            waiting: VecDeque::with_capacity(QUEUE_LEN),
            current: None,
            tp: SimpleTp::default(),
            stopping: false,
            moved: false,
            from: 0.0,
        }
    }

    /// Appends a move; letters that are NaN keep their position at the end of the path.
    pub(crate) fn push(
        &mut self,
        now: Pose,
        to: Pose,
        request: MoveRequest,
        machine: Machine<'_>,
        ticket: TicketHandle,
    ) -> Result<(), Refusal> {
        if self.stopping {
            return Err(Refusal::new("the machine is still coming to a stop"));
        }
        if self.waiting.len() >= QUEUE_LEN {
            return Err(Refusal::new("200 moves are waiting already"));
        }
        let last = self.waiting.back().map(|s| s.end);
        let start = last.or(self.current.map(|(line, _)| line.end)).unwrap_or(now);
        let mut end = start;
        for (place, wanted) in end.iter_mut().zip(to) {
            if wanted.is_finite() {
                *place = wanted;
            }
        }
        Line::plan(start, end, request, machine)?;
        self.waiting.push_back(Segment { end, request, ticket });
        Ok(())
    }

    /// Runs one cycle and returns the current pose. No move begins unless `may_begin`. Limits are checked when a move
    /// begins.
    pub(crate) fn step(
        &mut self,
        now: Pose,
        dt: f64,
        scale: f64,
        may_begin: bool,
        machine: Machine<'_>,
    ) -> Result<Pose, Refusal> {
        if self.current.is_none()
            && !self.stopping
            && may_begin
            && let Some(next) = self.waiting.pop_front()
        {
            match Line::plan(now, next.end, next.request, machine) {
                Ok(line) => self.begin(line, next.ticket),
                Err(why) => {
                    next.ticket.fail(why.text());
                    self.clear(why.text());
                    return Err(why);
                }
            }
        }
        self.moved = self.current.is_some();
        self.from = self.tp.pos;
        let Some((line, ticket)) = self.current else {
            self.stopping = false;
            return Ok(now);
        };
        self.tp.max_vel = if self.stopping { 0.0 } else { line.scaled(scale) };
        if line.length > 0.0 {
            self.tp.step_exactly(dt);
        }
        if self.tp.pos >= line.length && self.tp.vel == 0.0 {
            ticket.done();
            self.current = None;
            self.tp.reset(0.0);
            return Ok(line.end);
        }
        let pose = line.at(self.tp.pos);
        if self.stopping && self.tp.vel == 0.0 {
            ticket.fail("aborted");
            self.current = None;
            self.stopping = false;
            self.tp.reset(0.0);
        }
        Ok(pose)
    }

    /// Reduces the motion of this cycle to a part; returns the resulting pose, unless a move has just ended.
    pub(crate) fn slow_down(&mut self, factor: f64) -> Option<Pose> {
        let (line, _) = self.current?;
        self.tp.slow_down(self.from, factor);
        Some(line.at(self.tp.pos))
    }

    /// Makes the current move brake to velocity limits that were lowered. Its acceleration stays: with less, it could
    /// not stop at its end.
    pub(crate) fn lower_limits(&mut self, machine: Machine<'_>) {
        let Some((line, _)) = &mut self.current else { return };
        let Line { start, end, velocity, max_velocity, acceleration, .. } = *line;
        let request = MoveRequest { velocity, acceleration, max_velocity };
        if let Ok(new) = Line::plan(start, end, request, machine) {
            (line.velocity, line.max_velocity) = (new.velocity, new.max_velocity);
        }
    }

    const fn begin(&mut self, line: Line, ticket: TicketHandle) {
        self.tp.reset(0.0);
        self.tp.target = line.length;
        self.tp.max_acc = line.acceleration;
        self.tp.enable = true;
        self.current = Some((line, ticket));
    }

    /// Brakes along the path and discards the remaining moves.
    pub(crate) fn abort(&mut self) {
        for s in self.waiting.drain(..) {
            s.ticket.fail("aborted");
        }
        self.stopping = self.current.is_some();
    }

    /// Discards all moves at once.
    pub(crate) fn clear(&mut self, why: &'static str) {
        for s in self.waiting.drain(..) {
            s.ticket.fail(why);
        }
        if let Some((_, ticket)) = self.current.take() {
            ticket.fail(why);
        }
        self.stopping = false;
        self.tp.reset(0.0);
    }

    /// Returns whether the last cycle moved along a move.
    pub(crate) const fn has_moved(&self) -> bool {
        self.moved
    }

    /// Returns whether a move is in progress and not being aborted.
    pub(crate) const fn goes_on(&self) -> bool {
        self.current.is_some() && !self.stopping
    }

    pub(crate) fn is_idle(&self) -> bool {
        self.current.is_none() && self.waiting.is_empty()
    }

    /// Returns the current move.
    pub(crate) const fn line(&self) -> Option<&Line> {
        match &self.current {
            Some((line, _)) => Some(line),
            None => None,
        }
    }

    pub(crate) const fn velocity(&self) -> f64 {
        self.tp.vel
    }

    pub(crate) fn distance_to_go(&self) -> f64 {
        self.line().map_or(0.0, |line| line.length - self.tp.pos)
    }
}
