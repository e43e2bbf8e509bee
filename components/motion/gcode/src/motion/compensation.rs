//! Cutter radius compensation: its state, its queue, and the codes that turn it on and off.

use super::{
    arc::{in_plane, with_plane},
    geometry::Point,
};
use crate::{
    axis::Position,
    canon::{Call, Issued, Plane},
    error::Problem,
    interpret::{Run, block::Block, codes::GGroup},
    question::Request,
    state::{
        Compensation,
        compensation::{LastMove, Path},
    },
};

/// A smaller radius is none, in millimetres: it is below what a machine can tell.
const NO_RADIUS: f64 = 1e-6;

/// The largest coordinate and radius of a compensated path, in program units.
const LARGEST: f64 = 1e9;

/// The way to the point of a lathe tool's offset from the centre of its tip, in radii along X and Z, for each orientation.
const TIPS: [(f64, f64); 10] = [
    (0.0, 0.0),
    (-1.0, 1.0),
    (-1.0, -1.0),
    (1.0, -1.0),
    (1.0, 1.0),
    (0.0, 1.0),
    (-1.0, 0.0),
    (0.0, -1.0),
    (1.0, 0.0),
    (0.0, 0.0),
];

impl Run<'_> {
    /// Runs G40 to G42.1.
    pub(crate) fn compensation(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.g(GGroup::Compensation) else { return Ok(None) };
        if code == 400 {
            self.flush_compensation();
            let comp = &self.state.compensation;
            let ended = comp.ended || (comp.moves_path() && comp.program.is_some());
            self.end_compensation();
            self.state.compensation.ended = ended;
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
        let radius = libm::fabs(diameter) / 2.0;
        if !(0.0..=LARGEST).contains(&radius) {
            return Err(Problem::CompRange);
        }
        let is_none = radius * self.state.frame.unit.millimetres() < NO_RADIUS;
        self.state.compensation = Compensation {
            side: sign,
            radius: if is_none { 0.0 } else { radius },
            orientation,
            ended: self.state.compensation.ended,
            ..Compensation::default()
        };
        self.note_compensation()?;
        Ok(None)
    }

    /// Tells the side of compensation.
    pub(crate) fn note_compensation(&mut self) -> Result<(), Problem> {
        let side = if self.state.compensation.side > 0 { "left" } else { "right" };
        self.note(&format!("cutter radius compensation on {side}"))
    }

    /// Turns compensation off; the machine is where the last move ended.
    pub(crate) fn end_compensation(&mut self) {
        // What follows is relative to the programmed place, not to the tool's.
        self.state.position = self.programmed();
        self.state.compensation = Compensation::default();
    }

    /// Hands out the calls that wait; the end of the last move stays.
    pub(crate) fn flush_compensation(&mut self) {
        self.state.compensation.fixed = self.state.compensation.last.is_some();
        self.hand_out();
    }

    fn hand_out(&mut self) {
        let mut queue = core::mem::take(&mut self.state.compensation.queue);
        for issued in queue.drain(..) {
            let call = self.of_the_tip(issued.call);
            self.out.push(Issued { call, ..issued });
        }
        // The next moves use its memory again.
        self.state.compensation.queue = queue;
    }

    /// Returns a call of the compensated path as a call of the point that the tool's offset is of: the centre of a mill, and the
    /// corner of the lines that touch the tip of a lathe tool along the axes of its orientation.
    pub(crate) fn of_the_tip(&self, mut call: Call) -> Call {
        let comp = &self.state.compensation;
        let Some((x, z)) = TIPS.get(usize::from(comp.orientation)) else { return call };
        if !comp.is_on() || comp.program.is_none() || comp.orientation == 0 {
            return call;
        }
        let (x, z) = (x * comp.radius, z * comp.radius);
        match &mut call {
            Call::StraightFeed(end) | Call::StraightTraverse(end) => {
                (end.x, end.z) = (end.x + x, end.z + z);
            }
            Call::ArcFeed { end, centre_first, centre_second, .. } => {
                (end.x, end.z) = (end.x + x, end.z + z);
                // The plane XZ has Z as its first axis.
                (*centre_first, *centre_second) = (*centre_first + z, *centre_second + x);
            }
            _ => {}
        }
        call
    }

    /// Checks that a compensated move ends where a machine may be.
    pub(super) fn check_comp_range(&self, end: Point) -> Result<(), Problem> {
        let is_near = |v: f64| (-LARGEST..=LARGEST).contains(&v);
        if is_near(end.first) && is_near(end.second) { Ok(()) } else { Err(Problem::CompRange) }
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
    pub(super) fn change_last_end(&mut self, end: Point) -> Result<(), Problem> {
        let plane = self.state.modal.plane;
        if self.state.compensation.fixed {
            let moved = end.minus(in_plane(plane, self.state.position)).length();
            return if moved < self.hair() { Ok(()) } else { Err(Problem::CompFixed) };
        }
        for issued in &mut self.state.compensation.queue {
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
        self.hand_out();
        let comp = &mut self.state.compensation;
        comp.queue.push(issued);
        comp.last = Some(LastMove { path, direction });
        comp.fixed = false;
    }

    /// Returns the distance below which places of a compensated path are the same, in program units.
    pub(super) fn hair(&self) -> f64 {
        NO_RADIUS / self.state.frame.unit.millimetres()
    }
}
