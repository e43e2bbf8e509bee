//! Compensated straight moves.

use super::{
    arc::{in_plane, with_plane},
    corner::Next,
    geometry::Point,
    straight::length,
};
use crate::{
    axis::Position,
    canon::Call,
    error::Problem,
    interpret::{Run, block::Block},
    state::compensation::Path,
};

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
            if self.state.compensation.program.is_none() {
                return Err(Problem::CompEntryShort);
            }
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
        self.check_comp_range(new_end)?;
        if self.state.compensation.program.is_none() {
            if stop.minus(start).length() <= radius {
                return Err(Problem::CompEntryShort);
            }
        } else if let Some(last) = self.state.compensation.last {
            let begin = start.plus(normal, offset);
            let path = Path::Line { from: begin, direction };
            let size = stop.minus(start).length();
            self.corner(last, &Next { at: start, direction, path, size, rapid })?;
        }
        let begin = in_plane(plane, self.state.position);
        let to = with_plane(plane, end, new_end);
        if !rapid {
            self.inverse_feed(b, length(from, end))?;
        }
        // The path is the line through the new end: its begin may be off it at the entry.
        if self.state.compensation.program.is_some() && new_end.minus(begin).dot(direction) <= 0.0 {
            return Err(Problem::CompGouge);
        }
        let path = Path::Line { from: on_line(begin, new_end, direction), direction };
        self.push_move(make(to), path, direction);
        self.state.compensation.program = Some(stop);
        self.state.position = to;
        Ok(())
    }
}

/// Returns the foot of `point` on the line through `through`.
fn on_line(point: Point, through: Point, direction: Point) -> Point {
    through.plus(direction, point.minus(through).dot(direction))
}
