//! Compensated arcs.

use super::{
    arc::{Shape, in_plane, sweep, with_plane},
    corner::Next,
    geometry::Point,
};
use crate::{
    axis::Position,
    canon::Call,
    error::Problem,
    interpret::{Run, block::Block},
    state::compensation::Path,
};

/// Returns the direction of an arc at one of its points.
pub(super) fn tangent(at: Point, shape: Shape) -> Option<Point> {
    let out = at.minus(shape.centre).unit()?;
    let left = out.left();
    Some(if shape.turns > 0 { left } else { Point::default().minus(left) })
}

impl Run<'_> {
    /// Makes an arc with compensation to the programmed `end`.
    pub(super) fn compensated_arc(
        &mut self,
        b: &Block,
        end: Position,
        shape: Shape,
    ) -> Result<(), Problem> {
        let plane = self.state.modal.plane;
        let start = in_plane(plane, self.programmed());
        let stop = in_plane(plane, end);
        let offset = self.offset();
        let radius = start.minus(shape.centre).length();
        // To the left of a counterclockwise arc is its inside.
        let inward = if shape.turns > 0 { offset } else { -offset };
        let compensated = radius - inward;
        if compensated <= self.hair() {
            return Err(Problem::CompArcRadius);
        }
        let leave = tangent(stop, shape).ok_or(Problem::CompArcRadius)?;
        let new_end = stop.plus(leave.left(), offset);
        self.check_comp_range(new_end)?;
        if self.state.compensation.program.is_none() {
            return self.enter_by_arc(b, end, stop, new_end, leave, shape);
        }
        let enter = tangent(start, shape).ok_or(Problem::CompArcRadius)?;
        let begin = start.plus(enter.left(), offset);
        if let Some(last) = self.state.compensation.last {
            let Shape { centre, turns } = shape;
            let path = Path::Arc { from: begin, centre, radius: compensated, turns };
            let size = sweep(start, stop, shape) * compensated;
            self.corner(last, &Next { at: start, direction: enter, path, size, rapid: false })?;
        }
        let from = in_plane(plane, self.state.position);
        self.finish_arc(b, end, stop, new_end, leave, shape, from)
    }

    /// The first compensated move is an arc: it keeps its direction at the end, with another centre.
    fn enter_by_arc(
        &mut self,
        b: &Block,
        end: Position,
        stop: Point,
        new_end: Point,
        leave: Point,
        shape: Shape,
    ) -> Result<(), Problem> {
        let from = in_plane(self.state.modal.plane, self.state.position);
        let chord = from.minus(new_end);
        let inward =
            if shape.turns > 0 { leave.left() } else { Point::default().minus(leave.left()) };
        // The centre lies on the normal of the end, at the same distance from begin and end.
        let along = chord.dot(inward);
        if along <= 0.0 || self.state.compensation.radius >= from.minus(stop).length() {
            return Err(Problem::CompEntryShort);
        }
        let radius = chord.dot(chord) / (2.0 * along);
        let centre = new_end.plus(inward, radius);
        let shape = Shape { centre, turns: shape.turns };
        self.finish_arc(b, end, stop, new_end, leave, shape, from)
    }

    #[expect(clippy::too_many_arguments, reason = "the arc as programmed and as compensated")]
    fn finish_arc(
        &mut self,
        b: &Block,
        end: Position,
        stop: Point,
        new_end: Point,
        leave: Point,
        shape: Shape,
        from: Point,
    ) -> Result<(), Problem> {
        let plane = self.state.modal.plane;
        let to = with_plane(plane, end, new_end);
        let radius = new_end.minus(shape.centre).length();
        let (_, _, along) = plane.axes();
        // Time moves by the programmed length.
        let start = in_plane(plane, self.programmed());
        let programmed = start.minus(shape.centre).length() * sweep(start, stop, shape);
        let length = libm::hypot(programmed, to[along] - self.state.position[along]);
        self.inverse_feed(b, length)?;
        let call = Call::ArcFeed {
            plane,
            end: to,
            centre_first: shape.centre.first,
            centre_second: shape.centre.second,
            turns: shape.turns,
        };
        let path = Path::Arc { from, centre: shape.centre, radius, turns: shape.turns };
        self.push_move(call, path, leave);
        self.state.compensation.program = Some(stop);
        self.state.position = to;
        Ok(())
    }
}
