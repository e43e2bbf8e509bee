//! The path that motion plans for a program: with the rounded corners and the joined lines of its planner.

use super::Point;
use hal_gcode::{Call, Interpreter, Issued, axis::Position};
use hal_job::{Machine, clock::Clock};
use std::collections::VecDeque;

/// Reason why there is no such path.
pub(super) const UNKNOWN: &str =
    "the INI file does not state MAX_VELOCITY and MAX_ACCELERATION of every axis";

/// Kinds of points in a rapid move and in one at feed.
const RAPID: u8 = 1;
const FEED: u8 = 2;

/// The plan, and the moves of it that are not drawn yet.
#[derive(Debug)]
pub(super) struct PlannedPath {
    clock: Clock,
    /// Attributes of the moves, the first of which has this number.
    moves: VecDeque<Point>,
    first: u32,
}

impl PlannedPath {
    /// Begins at a point; `None` without the limits of the axes.
    pub(super) fn new(it: &Interpreter, machine: &Machine, begin: Point) -> Option<Self> {
        let mut clock = Clock::new(it, machine)?;
        clock.draw();
        Some(Self { clock, moves: VecDeque::from([begin]), first: 0 })
    }

    /// Plans a call, whose points have these attributes, and hands out the places that are final now.
    pub(super) fn call(
        &mut self,
        issued: &Issued,
        attributes: Point,
        each: &mut dyn FnMut(Position, Point),
    ) {
        let moves = matches!(
            issued.call,
            Call::StraightTraverse(_)
                | Call::StraightFeed(_)
                | Call::StraightProbe { .. }
                | Call::RigidTap { .. }
                | Call::ArcFeed { .. }
                | Call::NurbsFeed { .. }
        );
        if moves {
            self.moves.push_back(attributes);
        }
        let last = self.moves.len().saturating_sub(1);
        let line = self.first.saturating_add(u32::try_from(last).unwrap_or(u32::MAX));
        // What the planner refuses, the check of the program reports.
        let _refused = self.clock.call(&Issued { line, ..issued.clone() });
        self.hand_out(each);
    }

    /// Hands out the rest of the path.
    pub(super) fn finish(&mut self, each: &mut dyn FnMut(Position, Point)) {
        self.clock.finish();
        self.hand_out(each);
    }

    fn hand_out(&mut self, each: &mut dyn FnMut(Position, Point)) {
        for place in self.clock.places() {
            while self.first < place.line && self.moves.len() > 1 {
                self.moves.pop_front();
                self.first += 1;
            }
            if let Some(attributes) = self.moves.front() {
                let is_blend = attributes.kind == RAPID && !place.is_rapid;
                let kind = if is_blend { FEED } else { attributes.kind };
                each(place.at, Point { kind, ..*attributes });
            }
        }
    }

    /// Returns the memory that it takes, in bytes.
    pub(super) fn memory(&self) -> usize {
        self.clock.memory() + self.moves.capacity() * size_of::<Point>()
    }
}
