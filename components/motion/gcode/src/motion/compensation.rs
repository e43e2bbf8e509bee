//! Cutter radius compensation: its state, its queue, and the codes that turn it on and off.

use serde::{Deserialize, Serialize};

use super::{
    arc::{in_plane, with_plane},
    geometry::Point,
};
use crate::{
    axis::Position,
    canon::{Call, Plane},
    environment::Request,
    error::Problem,
    interpret::{Issued, Run, block::Block, codes::GGroup},
    state::Side,
};

/// The compensated path of the last move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Path {
    /// A line from this point in this direction.
    Line {
        /// The start point.
        from: Point,
        /// The unit direction.
        direction: Point,
    },
    /// An arc.
    Arc {
        /// The start point.
        from: Point,
        /// The centre.
        centre: Point,
        /// The radius.
        radius: f64,
        /// The number of turns, negative for clockwise.
        turns: i32,
    },
}

/// The last move, whose end the next one may change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Last {
    /// The compensated path.
    pub path: Path,
    /// The programmed direction at its end.
    pub direction: Point,
    /// The place of its call in the queue.
    pub index: usize,
}

/// The state of cutter radius compensation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Compensation {
    /// Twice the side: the sign is that of the left normal.
    side: i8,
    /// The radius of the tool.
    pub radius: f64,
    /// The orientation of a lathe tool.
    pub orientation: u8,
    /// The programmed position; `None` before the first move.
    pub program: Option<Point>,
    /// The last move, if its end may still change.
    pub last: Option<Last>,
    /// The calls from the last move on.
    pub queue: Vec<Issued>,
}

impl Compensation {
    /// Tells whether compensation is on.
    pub fn is_on(&self) -> bool {
        self.side != 0
    }

    /// Returns the side.
    pub fn side(&self) -> Side {
        match self.side {
            0 => Side::Off,
            1.. => Side::Left,
            _ => Side::Right,
        }
    }

    /// Returns 1 for the left side and -1 for the right one.
    pub(crate) fn sign(&self) -> f64 {
        f64::from(self.side)
    }

    /// Tells whether calls wait for the end of a move.
    pub(crate) fn holds(&self) -> bool {
        self.last.is_some()
    }

    /// Forgets the path after motion from elsewhere.
    pub(crate) fn forget(&mut self) {
        self.program = None;
        self.last = None;
        self.queue.clear();
    }
}

impl Run<'_> {
    /// Runs G40 to G42.1.
    pub(crate) fn compensation(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.g(GGroup::Compensation) else { return Ok(None) };
        if code == 400 {
            self.flush_compensation();
            self.end_compensation();
            self.note("cutter radius compensation off")?;
            return Ok(None);
        }
        let plane = self.state.modal.plane;
        if !matches!(plane, Plane::Xy | Plane::Xz) {
            return Err(Problem::CompPlane);
        }
        if self.state.compensation.is_on() {
            return Err(Problem::CompOn);
        }
        let name = match code {
            410 => "G41",
            411 => "G41.1",
            420 => "G42",
            _ => "G42.1",
        };
        let k = self.table_scale();
        let (diameter, orientation) = if matches!(code, 411 | 421) {
            let d = b.get(b'd').ok_or(Problem::CompNeedsD { code: name })?;
            let l = b.integer(b'l')?;
            if l.is_some() && plane != Plane::Xz {
                return Err(Problem::CompLPlane { code: name });
            }
            let l = u8::try_from(l.unwrap_or(0)).ok().filter(|l| *l <= 9);
            (d, l.ok_or(Problem::CompLRange { code: name })?)
        } else {
            let tool = match b.integer(b'd')? {
                None | Some(0) => self.state.tool.clone(),
                Some(d) => self.tool(d)?,
            };
            (tool.diameter * k, tool.orientation)
        };
        if orientation != 0 && plane != Plane::Xz {
            return Err(Problem::CompLathePlane { code: name });
        }
        let left = code < 420;
        // A negative diameter is a tool on the other side.
        let sign = if left == (diameter >= 0.0) { 1 } else { -1 };
        let comp = &mut self.state.compensation;
        *comp = Compensation {
            side: sign,
            radius: libm::fabs(diameter) / 2.0,
            orientation,
            ..Compensation::default()
        };
        self.note(&format!(
            "cutter radius compensation on {}",
            if sign > 0 { "left" } else { "right" }
        ))?;
        Ok(None)
    }

    /// Turns compensation off; the machine is where the last move ended.
    pub(crate) fn end_compensation(&mut self) {
        // What follows is relative to the programmed place, not to the tool's.
        self.state.position = self.programmed();
        self.state.compensation = Compensation::default();
    }

    /// Hands out the calls that wait; the end of the last move stays.
    pub(crate) fn flush_compensation(&mut self) {
        self.state.compensation.last = None;
        self.out.append(&mut self.state.compensation.queue);
    }

    /// Returns the programmed position, without compensation.
    pub(crate) fn programmed(&self) -> Position {
        let state = &*self.state;
        match state.compensation.program {
            Some(at) if state.compensation.is_on() => {
                with_plane(state.modal.plane, state.position, at)
            }
            _ => state.position,
        }
    }

    /// Moves the end of the last move to `end`, with the calls behind it that stay there.
    pub(super) fn change_last_end(&mut self, last: Last, end: Point) -> Result<(), Problem> {
        let plane = self.state.modal.plane;
        check_reach(last.path, in_plane(plane, self.state.position), end)?;
        let queue = &mut self.state.compensation.queue;
        for issued in queue.iter_mut().skip(last.index) {
            match &mut issued.call {
                Call::StraightFeed(p)
                | Call::StraightTraverse(p)
                | Call::ArcFeed { end: p, .. } => {
                    *p = with_plane(plane, *p, end);
                }
                _ => {}
            }
        }
        self.state.position = with_plane(plane, self.state.position, end);
        Ok(())
    }

    /// Adds a move whose end the next one may change.
    pub(super) fn push_move(&mut self, call: Call, path: Path, direction: Point) {
        let issued = Issued { call, line: self.line, number: self.number };
        let comp = &mut self.state.compensation;
        self.out.append(&mut comp.queue);
        comp.queue.push(issued);
        comp.last = Some(Last { path, direction, index: 0 });
    }
}

/// Checks that the new end of a path lies between its begin and its old end.
fn check_reach(path: Path, old: Point, new: Point) -> Result<(), Problem> {
    match path {
        Path::Line { from, direction } => {
            if new.minus(from).dot(direction) <= 0.0 {
                return Err(Problem::CompGouge);
            }
        }
        Path::Arc { from, centre, turns, .. } => {
            let shape = super::arc::Shape { centre, turns };
            let (was, is) =
                (super::arc::sweep(from, old, shape), super::arc::sweep(from, new, shape));
            if is > was + 1e-9 {
                return Err(Problem::CompGougeArc);
            }
        }
    }
    Ok(())
}
