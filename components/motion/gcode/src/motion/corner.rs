//! Corners of a compensated path.

use core::f64::consts::{PI, TAU};

use super::{
    arc::{Shape, in_plane, sweep, with_plane},
    geometry::{Course, Point},
};
use crate::{
    canon::Call,
    error::Problem,
    interpret::Run,
    state::compensation::{LastMove, Path},
};

/// A path that turns by more than this, in radians, may come back on itself.
const REVERSAL: f64 = PI - 0.1;

/// Outside corners between lines with a smaller turn, in radians, are pointed: the tool leaves the corner by less than
/// 0.04 % of its radius.
const SMALL_TURN: f64 = 0.05;

/// Motion takes smaller arcs, in radians, for none or a full turn.
const SMALL_ARC: f64 = 1e-6;

/// Lines between whose directions the cross product is smaller are parallel.
const PARALLEL: f64 = 1e-12;

/// The move behind a corner.
pub(super) struct Next {
    /// The programmed corner.
    pub(super) at: Point,
    /// The programmed direction there.
    pub(super) direction: Point,
    /// The compensated path, from its begin beside the corner.
    pub(super) path: Path,
    /// The length of the compensated path from there.
    pub(super) size: f64,
    /// True for a rapid move.
    pub(super) rapid: bool,
}

impl LastMove {
    /// Returns the length of the move up to its end.
    fn size(&self, end: Point) -> f64 {
        match self.path {
            Path::Line { from, .. } => self.path.way(from, end),
            Path::Arc { from, centre, radius, turns } => {
                radius * sweep(from, end, Shape { centre, turns })
            }
        }
    }
}

impl Path {
    fn from(&self) -> Point {
        match self {
            Self::Line { from, .. } | Self::Arc { from, .. } => *from,
        }
    }

    /// Returns the length from one place of the path forward to another, from 0 on; on an arc less than a turn.
    fn way(&self, a: Point, b: Point) -> f64 {
        match self {
            Self::Line { direction, .. } => b.minus(a).dot(*direction),
            Self::Arc { centre, radius, turns, .. } => {
                let (a, b) = (a.minus(*centre), b.minus(*centre));
                let angle = libm::atan2(a.cross(b), a.dot(b));
                let angle = if *turns < 0 { -angle } else { angle };
                let angle = if angle < -SMALL_ARC { angle + TAU } else { angle };
                angle * radius
            }
        }
    }

    /// Returns the shortest length that a path may have.
    fn shortest(&self, hair: f64) -> f64 {
        match self {
            Self::Line { .. } => 0.0,
            Self::Arc { radius, .. } => hair.max(SMALL_ARC * radius),
        }
    }

    fn course(&self) -> Course {
        match *self {
            Self::Line { from, direction } => Course::Line(from, direction),
            Self::Arc { centre, radius, .. } => Course::Circle(centre, radius),
        }
    }

    /// Returns the meeting points of the whole lines and circles of two paths.
    fn meetings(&self, other: &Self) -> Option<[Point; 2]> {
        self.course().meetings(other.course(), PARALLEL)
    }

    /// Returns the curvature of the programmed path, positive to the left; `offset` is the way to the left from it.
    fn curvature(&self, offset: f64) -> f64 {
        match self {
            Self::Line { .. } => 0.0,
            Self::Arc { radius, turns, .. } if *turns > 0 => 1.0 / (radius + offset),
            Self::Arc { radius, .. } => -1.0 / (radius - offset),
        }
    }
}

impl Run<'_> {
    /// Makes the corner between the last move and the next one.
    pub(super) fn corner(&mut self, last: LastMove, next: &Next) -> Result<(), Problem> {
        let compensation = &self.state.compensation;
        let (radius, sign) = (compensation.radius, compensation.sign());
        let turn = turn(last.direction, next.direction) * sign;
        // The path goes straight on, as far as a machine can tell.
        if radius * turn * turn / 2.0 < self.hair() {
            return self.go_on(next);
        }
        let is_inside = self.comes_back(last, next).unwrap_or(turn > 0.0);
        if is_inside { self.inside_corner(last, next) } else { self.round_corner(last, next) }
    }

    /// Tells whether a path that comes back on itself comes back on the side of the tool, which is then between both
    /// ways and not round their end; `None` where the turn tells it.
    ///
    /// Seen from the way back along the last move, the next one goes aside by `angle * l + bend * l * l / 2`.
    fn comes_back(&self, last: LastMove, next: &Next) -> Option<bool> {
        if libm::fabs(turn(last.direction, next.direction)) < REVERSAL {
            return None;
        }
        let (offset, side) = (self.offset(), -self.state.compensation.sign());
        let angle = side * turn(Point::default().minus(last.direction), next.direction);
        let (before, after) = (last.path.curvature(offset), next.path.curvature(offset));
        let bend = side * (before + after);
        let sharpest = libm::fabs(before).max(libm::fabs(after));
        let at = in_plane(self.state.modal.plane, self.state.position);
        let length = next.size.min(last.size(at)).min(0.1 / sharpest);
        let aside = angle * length + bend * length * length / 2.0;
        if libm::fabs(aside) < self.hair() {
            return Some(false);
        }
        // The ways may cross near the corner; what is between them there is no part of the contour.
        let is_crossing =
            angle * bend < 0.0 && angle * angle < 2.0 * self.hair() * libm::fabs(bend);
        is_crossing.then_some(aside > 0.0)
    }

    /// Goes straight on to the next move, which must be longer than the rest of the corner.
    fn go_on(&self, next: &Next) -> Result<(), Problem> {
        let at = in_plane(self.state.modal.plane, self.state.position);
        let begun = at.minus(next.path.from()).dot(next.direction);
        if begun < next.size - next.path.shortest(self.hair()) {
            return Ok(());
        }
        Err(no_room(&next.path))
    }

    /// Ends the last move where the tool touches both moves.
    fn inside_corner(&mut self, last: LastMove, next: &Next) -> Result<(), Problem> {
        let hair = self.hair();
        let at = in_plane(self.state.modal.plane, self.state.position);
        let size = last.size(at);
        let Some(meetings) = last.path.meetings(&next.path) else {
            return Err(Problem::CompNoIntersection);
        };
        let (least, most) = (last.path.shortest(hair), next.path.shortest(hair));
        let reached = meetings.into_iter().filter(|m| {
            let (back, ahead) = (last.path.way(*m, at), next.path.way(next.path.from(), *m));
            -hair < back && back < size - least && -hair < ahead && ahead < next.size - most
        });
        let nearer = |a: &Point, b: &Point| last.path.way(*a, at).total_cmp(&last.path.way(*b, at));
        match reached.min_by(nearer) {
            Some(meeting) => self.change_last_end(meeting),
            None => Err(no_room(&last.path)),
        }
    }

    /// Returns the signed distance from the programmed path to the compensated one, to the left.
    pub(super) fn offset(&self) -> f64 {
        self.state.compensation.radius * self.state.compensation.sign()
    }

    /// Goes round an outside corner to the begin of the next move.
    fn round_corner(&mut self, last: LastMove, next: &Next) -> Result<(), Problem> {
        let plane = self.state.modal.plane;
        let begin = next.path.from();
        let to = with_plane(plane, self.state.position, begin);
        let turned = libm::fabs(turn(last.direction, next.direction));
        let lines = [last.path, next.path].iter().all(|p| matches!(p, Path::Line { .. }));
        if lines
            && turned < SMALL_TURN
            && !self.state.compensation.fixed
            && let Some([point, _]) = last.path.meetings(&next.path)
        {
            return self.change_last_end(point);
        }
        self.flush_compensation();
        if next.rapid {
            // A rapid move is straight: three lines touch the circle round the corner from outside.
            let side = self.state.compensation.radius * libm::tan(turned / 4.0);
            let from = in_plane(plane, self.state.position);
            let beside = [from.plus(last.direction, side), begin.plus(next.direction, -side)];
            for place in beside {
                let place = with_plane(plane, self.state.position, place);
                self.emit(Call::StraightTraverse(place))?;
            }
            self.emit(Call::StraightTraverse(to))?;
        } else {
            let turns = if self.state.compensation.sign() > 0.0 { -1 } else { 1 };
            self.emit_arc(to, Shape { centre: next.at, turns })?;
        }
        self.state.position = to;
        Ok(())
    }
}

/// Returns the problem of a corner without room for the tool behind or before it.
fn no_room(path: &Path) -> Problem {
    match path {
        Path::Line { .. } => Problem::CompGouge,
        Path::Arc { .. } => Problem::CompGougeArc,
    }
}

/// Returns the turn from one direction to another in radians, positive to the left.
fn turn(from: Point, to: Point) -> f64 {
    libm::atan2(from.cross(to), from.dot(to))
}
