//! Compensated straight moves.

use super::{
    arc::{Shape, in_plane, with_plane},
    geometry::{Point, circles, line_circle, nearest},
    straight::length,
};
use crate::{
    axis::Position,
    canon::Call,
    error::Problem,
    interpret::{Run, block::Block},
    state::compensation::{LastMove, Path},
};

/// Corners with a smaller turn, in radians, get neither an arc nor a new end.
const SMALL_TURN: f64 = 0.05;

/// A path that turns by more than this, in radians, goes back: the tool goes round its end, unless its paths meet.
const REVERSAL: f64 = core::f64::consts::PI - 1e-6;

impl Run<'_> {
    /// Makes a straight move with compensation to the programmed `end`.
    pub(super) fn compensated_line(
        &mut self,
        b: &Block,
        end: Position,
        rapid: bool,
    ) -> Result<(), Problem> {
        let plane = self.state.modal.plane;
        let from = self.programmed();
        let (start, stop) = (in_plane(plane, from), in_plane(plane, end));
        let at = in_plane(plane, self.state.position);
        let make =
            |p: Position| if rapid { Call::StraightTraverse(p) } else { Call::StraightFeed(p) };
        let Some(direction) = stop.minus(start).unit() else {
            // No motion in the plane: the compensated place stays, and may still change with the last move.
            let to = with_plane(plane, end, at);
            if !rapid {
                self.inverse_feed(b, length(self.state.position, to))?;
            }
            self.emit(make(to))?;
            self.state.position = to;
            return Ok(());
        };
        let radius = self.state.compensation.radius;
        let normal = direction.left();
        let offset = radius * self.state.compensation.sign();
        let new_end = stop.plus(normal, offset);
        if self.state.compensation.program.is_none() {
            if stop.minus(start).length() <= radius {
                return Err(Problem::CompEntryShort);
            }
        } else if let Some(last) = self.state.compensation.last {
            self.corner_to_line(last, start, direction, rapid)?;
        }
        let begin = in_plane(plane, self.state.position);
        let to = with_plane(plane, end, new_end);
        if !rapid {
            self.inverse_feed(b, length(from, end))?;
        }
        // The path is the line through the new end: its begin may be off it at the entry.
        let path = Path::Line { from: on_line(begin, new_end, direction), direction };
        self.push_move(make(to), path, direction);
        self.state.compensation.program = Some(stop);
        self.state.position = to;
        Ok(())
    }

    /// Makes the corner at the programmed point `at` between the last move and a line in `direction`.
    fn corner_to_line(
        &mut self,
        last: LastMove,
        at: Point,
        direction: Point,
        rapid: bool,
    ) -> Result<(), Problem> {
        let offset = self.offset();
        let begin = at.plus(direction.left(), offset);
        match turn(last.direction, direction) * self.state.compensation.sign() {
            t if libm::fabs(t) < SMALL_TURN => Ok(()),
            t if t < 0.0 && t > -REVERSAL => self.round_corner(at, begin, rapid),
            t => {
                let meeting = match last.path {
                    Path::Line { .. } => meeting_of_lines(at, last.direction, direction, offset),
                    Path::Arc { centre, radius, .. } => {
                        line_circle(begin, direction, centre, radius).map(|p| nearest(p, at))
                    }
                };
                match meeting {
                    Some(meeting) => self.change_last_end(last, meeting),
                    None if libm::fabs(t) > REVERSAL => self.round_corner(at, begin, rapid),
                    None => Err(Problem::CompNoIntersection),
                }
            }
        }
    }

    /// Returns the signed distance from the programmed path to the compensated one, to the left.
    pub(super) fn offset(&self) -> f64 {
        self.state.compensation.radius * self.state.compensation.sign()
    }

    /// Goes round a convex corner to `begin`, the compensated begin of the next move.
    pub(super) fn round_corner(
        &mut self,
        at: Point,
        begin: Point,
        rapid: bool,
    ) -> Result<(), Problem> {
        let plane = self.state.modal.plane;
        let to = with_plane(plane, self.state.position, begin);
        self.flush_compensation();
        if rapid {
            self.emit(Call::StraightTraverse(to))?;
        } else {
            let turns = if self.state.compensation.sign() > 0.0 { -1 } else { 1 };
            self.emit_arc(to, Shape { centre: at, turns })?;
        }
        self.state.position = to;
        Ok(())
    }

    /// Makes the corner between the last move and an arc; `begin` is the compensated begin of the arc.
    pub(super) fn corner_to_arc(
        &mut self,
        last: LastMove,
        at: Point,
        direction: Point,
        begin: Point,
        (centre, radius): (Point, f64),
    ) -> Result<(), Problem> {
        match turn(last.direction, direction) * self.state.compensation.sign() {
            t if libm::fabs(t) < SMALL_TURN => Ok(()),
            t if t < 0.0 && t > -REVERSAL => self.round_corner(at, begin, false),
            t => {
                let meeting = match last.path {
                    Path::Line { from, direction } => line_circle(from, direction, centre, radius),
                    Path::Arc { centre: other, radius: r, .. } => circles(other, r, centre, radius),
                };
                match meeting.map(|p| nearest(p, at)) {
                    Some(meeting) => self.change_last_end(last, meeting),
                    None if libm::fabs(t) > REVERSAL => self.round_corner(at, begin, false),
                    None => Err(Problem::CompNoIntersection),
                }
            }
        }
    }
}

/// Returns the turn from one direction to another in radians, positive to the left.
pub(super) fn turn(from: Point, to: Point) -> f64 {
    libm::atan2(from.cross(to), from.dot(to))
}

/// Returns the meeting point of two lines at the distance `offset` to the left of a corner's sides.
fn meeting_of_lines(at: Point, d1: Point, d2: Point, offset: f64) -> Option<Point> {
    let (n1, n2) = (d1.left(), d2.left());
    let scale = 1.0 + n1.dot(n2);
    if scale < 1e-9 {
        return None;
    }
    Some(at.plus(n1, offset / scale).plus(n2, offset / scale))
}

/// Returns the foot of `point` on the line through `through`.
fn on_line(point: Point, through: Point, direction: Point) -> Point {
    through.plus(direction, point.minus(through).dot(direction))
}
