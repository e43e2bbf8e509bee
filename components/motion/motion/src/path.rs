//! Realtime. The path: a queue of moves, the planner's path that the axes follow, and its stops, pauses and reversals.

mod coord;
mod drive;
pub(crate) mod image;
mod lead;
pub(crate) mod order;
mod pace;
mod progress;
mod queue;
mod reach;
mod retract;
mod spindle;
mod stop;
mod stopped_spindle;
mod sweep;
mod tap;
mod tracker;
pub(crate) mod worker;

use crate::commands::{command::Sync, refusal::Refusal};
pub(crate) use drive::Drive;
use hal_component::{Gives, Pose, SeqWriter, TicketHandle};
use hal_trajectory::{Pursuit, Scales, Step};
use libm::fabs;
use order::{HandOver, Item, Kind, Order, PathSetup, Rider, Session};
use retract::Retract;
use spindle::{Course, OVERRUN_TURNS};
use std::collections::VecDeque;
use tracker::Tracker;

/// Capacity of the move queue.
pub(crate) const QUEUE_LEN: usize = 2000;

/// Number of moves whose lines are known, for reverse motion; a power of two.
const KNOWN: usize = 4096;

/// Rounding of a pose on the path, in units and relative to a coordinate.
const ROUNDING: f64 = 1e-12;

/// An element of the path that has not ended.
#[derive(Clone, Copy, Debug)]
struct Pending {
    id: u32,
    item: Item,
    /// Pose at the end.
    end: Pose,
    ticket: Option<TicketHandle>,
}

/// Properties of a move, kept after its end.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Known {
    pub(crate) id: u32,
    pub(crate) line: u32,
    pub(crate) kind: Kind,
    pub(crate) end: Pose,
    /// Length of an arc and its angle in turns; 0 for lines.
    length: f64,
    turns: f64,
    /// Centre and radius of an arc.
    circle: ([f64; 3], f64),
    /// Spindle that the move follows.
    sync: Option<Sync>,
}

/// State of the hand-over to the planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Live {
    /// There is no path.
    Rest,
    /// The planner must begin a path from here.
    Wanted,
    /// The planner has been asked to begin a path.
    Asked,
    /// The axes follow a path.
    Follows,
}

/// Reason for which the path brakes.
#[derive(Clone, Copy, Debug)]
enum Stop {
    /// The path ends.
    Abort(Refusal),
    /// The rest of the path is planned again, for other limits.
    Replan,
    /// The probe has changed: the path ends.
    Probed,
}

/// Place of the axes relative to a paused path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Parked {
    #[default]
    No,
    /// The axes jog; the path goes on from this pose.
    Away(Pose),
    /// The axes go back to this pose.
    Returns(Pose),
    /// The axes rest at this pose, for a cycle.
    Back(Pose),
}

/// A path of moves, planned by the worker and followed here.
#[derive(Debug)]
pub(crate) struct Path {
    hand: Gives<HandOver>,
    setup: SeqWriter<PathSetup>,
    generation: u32,
    live: Live,
    session: Option<Box<Session>>,
    /// A path to be freed for which there was no room.
    spare: Option<Box<Session>>,
    pending: VecDeque<Pending>,
    /// Number of elements of `pending` that the planner has.
    sent: usize,
    /// Kind of the path, and its relation to the spindle.
    course: Course,
    tracker: Tracker,
    retract: Retract,
    /// True once the planner was told that this path has no more moves.
    is_finishing: bool,
    /// True if the planner waits to accept moves again after a refusal.
    resume_due: bool,
    next_id: u32,
    known: Box<[Known]>,
    /// End of the path, and of the last move that has ended.
    end: Pose,
    base: Pose,
    stop: Option<Stop>,
    paused: bool,
    parked: Parked,
    /// Cycles until the end of a pause; 0 without one that ends.
    resume_in: u32,
    reverse: bool,
    /// Number of the move at whose end a single step pauses.
    step_of: Option<u32>,
    last: Step,
    /// Velocity of the group of axes that governs the feed, and its travel since the start of the current move.
    velocity: f64,
    travelled: f64,
    /// Direction in x and y, in degrees, and a step in that direction.
    heading: f64,
    direction: [f64; 2],
    scales: Scales,
    /// Reason of the last move that the planner refused, until it is taken.
    refused: Option<Refusal>,
    /// Reason for which the path failed otherwise, until it is taken.
    failed: Option<Refusal>,
    /// True if a probe move has found its place, until it is taken.
    probed: bool,
    /// Number of the probe move whose start was checked.
    probe_begun: u32,
}

const AT_REST: Step = Step {
    pose: hal_trajectory::Pose::ZERO,
    line: 0,
    travel: 0.0,
    lead: 1.0,
    feed: 0.0,
    highest: 0.0,
    moving: false,
    rests: true,
};

impl Path {
    pub(crate) fn new(hand: Gives<HandOver>, setup: SeqWriter<PathSetup>) -> Self {
        Self {
            hand,
            setup,
            generation: 0,
            live: Live::Rest,
            session: None,
            spare: None,
            pending: VecDeque::with_capacity(QUEUE_LEN),
            sent: 0,
            course: Course::Free,
            tracker: Tracker::default(),
            retract: Retract::No,
            is_finishing: false,
            resume_due: false,
            next_id: 1,
            known: vec![Known::default(); KNOWN].into_boxed_slice(),
            end: [0.0; 9],
            base: [0.0; 9],
            stop: None,
            paused: false,
            parked: Parked::No,
            resume_in: 0,
            reverse: false,
            step_of: None,
            last: AT_REST,
            velocity: 0.0,
            travelled: 0.0,
            heading: 0.0,
            direction: [0.0; 2],
            scales: Scales::FULL,
            refused: None,
            failed: None,
            probed: false,
            probe_begun: 0,
        }
    }

    /// Returns whether a path must begin: [`Self::begin`] comes next.
    pub(crate) fn is_wanted(&self) -> bool {
        self.live == Live::Wanted
    }

    /// Asks the planner to begin a path at this place, with these limits.
    pub(crate) fn begin(&mut self, mut setup: PathSetup) {
        self.generation = self.generation.wrapping_add(1);
        setup.generation = self.generation;
        let next = self.next_move().map(|(id, order)| (id, order.sync));
        self.course = next.map_or(Course::Free, |(id, sync)| Course::of(id, sync));
        setup.is_bound = self.course != Course::Free;
        self.permit_retract();
        if matches!(self.course, Course::Tap(_)) {
            let pitch = next.and_then(|(_, sync)| sync).map_or(0.0, |s| s.pitch);
            setup.overrun = OVERRUN_TURNS * pitch;
        }
        self.setup.set(&setup);
        self.hand.set_latest(self.generation);
        let order = Order::Begin { generation: self.generation };
        if self.hand.orders.push(order).is_ok() {
            self.live = Live::Asked;
        }
    }

    /// Runs one cycle. Returns the pose on the path, if there is one.
    pub(crate) fn step(&mut self, drive: Drive) -> Option<Pose> {
        self.take_reports();
        self.take_session();
        self.send();
        self.velocity = 0.0;
        if self.resume_in > 0 {
            self.resume_in -= 1;
            self.paused &= self.resume_in > 0;
        }
        let retracts = self.retracts(&drive);
        if !self.paused && drive.may_begin {
            self.refuse_probe(drive.probe, &drive.scales);
        }
        let session = self.session.as_mut()?;
        let is_paused = self.paused && !retracts;
        let holds = self.stop.is_some() || is_paused || self.last.rests && !drive.may_begin;
        let reverse = self.reverse != drive.reverse;
        let (scales, tops) = match retracts {
            true => (drive.retract, drive.retract_tops),
            false => (drive.scales, drive.tops),
        };
        self.scales = scales;
        if drive.pace.is_some() {
            // Overrides and holds wait until the spindle is free.
            self.scales = Scales::FULL;
        }
        let scales = if holds { Scales::HOLD } else { self.scales };
        let step = match &mut session.rider {
            Rider::Follower(follower) => {
                follower.limit(tops);
                follower.step(&session.way, scales, reverse)
            }
            Rider::Pursuer(pursuer) => {
                pursuer.limit(tops);
                let goal = drive.pace.map_or(Pursuit::Rest, |pace| pace.goal);
                pursuer.step(&session.way, goal)
            }
        };
        self.hand.set_input(session.input());
        let is_at_end = session.is_done() && !step.moving;
        let travel = step.lead * step.travel;
        self.velocity = fabs(travel) / drive.dt;
        self.travelled = if step.line == self.last.line { self.travelled } else { 0.0 };
        self.travelled += travel;
        self.turn_heading(&step);
        self.last = step;
        if drive.pace.is_some_and(|p| !p.waits) {
            self.keep_pace(&step);
        }
        self.watch_probe(drive.probe);
        self.end_moves(is_at_end);
        self.end_step();
        if !step.moving {
            self.end_stop();
        }
        Some(self.exact_end(is_at_end).unwrap_or(step.pose.0))
    }

    /// Returns the programmed end of the path if the motion rests there but for rounding.
    fn exact_end(&self, is_at_end: bool) -> Option<Pose> {
        let end = self.known(self.last.line).filter(|_| is_at_end)?.end;
        let near = |(a, b): (&f64, &f64)| fabs(a - b) <= ROUNDING * (1.0 + fabs(*b));
        end.iter().zip(&self.last.pose.0).all(near).then_some(end)
    }

    fn take_session(&mut self) {
        while !self.hand.made.is_empty()
            && let Some(session) = self.hand.made.pop()
        {
            if session.generation == self.generation && self.live == Live::Asked {
                self.live = Live::Follows;
                self.hand.set_input((0, 0.0));
                let old = self.session.replace(session);
                self.give_back(old);
            } else {
                self.give_back(Some(session));
            }
        }
    }

    /// Returns a path to the planner, which frees it.
    fn give_back(&mut self, old: Option<Box<Session>>) {
        for session in [self.spare.take(), old].into_iter().flatten() {
            if let Err(session) = self.hand.old.push(session) {
                self.spare = Some(session);
            }
        }
    }

    fn known(&self, id: u32) -> Option<&Known> {
        self.known.get(id as usize % KNOWN).filter(|k| k.id == id && id != 0)
    }

    /// Takes the reason of a refusal by the planner.
    pub(crate) const fn take_refused(&mut self) -> Option<Refusal> {
        self.refused.take()
    }

    /// Returns whether the last cycle moved along the path.
    pub(crate) fn has_moved(&self) -> bool {
        self.session.is_some() && self.last.moving
    }

    /// Returns whether moves are in progress and not being aborted.
    pub(crate) fn goes_on(&self) -> bool {
        !self.pending.is_empty() && self.stop.is_none()
    }

    pub(crate) fn is_idle(&self) -> bool {
        self.pending.is_empty() && !self.last.moving
    }

    /// Returns the current move.
    pub(crate) fn current(&self) -> Option<&Known> {
        if self.is_idle() { None } else { self.known(self.last.line) }
    }

    pub(crate) const fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Returns whether the axes may leave the path: it is paused, rests, and is not over.
    pub(crate) fn can_park(&self) -> bool {
        self.paused
            && !self.last.moving
            && self.stop.is_none()
            && self.live == Live::Follows
            && !self.pending.is_empty()
    }

    pub(crate) const fn parked(&self) -> Parked {
        self.parked
    }

    pub(crate) const fn set_parked(&mut self, parked: Parked) {
        self.parked = parked;
        self.retract = Retract::No;
    }

    pub(crate) const fn is_paused(&self) -> bool {
        self.paused
    }

    /// Returns whether the path runs backwards, with the direction of the adaptive feed.
    pub(crate) fn is_reverse(&self, adaptive: bool) -> bool {
        self.session.is_some() && self.reverse != adaptive
    }

    /// Returns the number of moves that have not ended.
    pub(crate) fn depth(&self) -> usize {
        self.pending.len()
    }
}

fn less(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}
