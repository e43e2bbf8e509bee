//! T-mode: a program as ticks, each of which moves X, Y and Z by one step or none.
//!
//! | module | subject |
//! |---|---|
//! | [`line`](mod@line) | straight moves: Bresenham's algorithm for three axes |
//! | [`arc`](mod@arc) | arcs in XY: the nearest step along the circle |
//! | [`figures`] | the figures of a whole program |
//!
//! [`Ticks`] follows the canonical calls of a program and hands out the ticks of each move. The ends of moves are rounded to
//! steps in machine coordinates, so that steps never drift away from the program. A move takes the time of its length at its
//! feed, evenly on its ticks, and each tick a thousandth of a second at least.

pub mod arc;
pub mod figures;
pub mod line;

use crate::{
    axis::{Axis, Position},
    canon::{Call, Frame, Issued, Plane, Unit},
    error::Problem,
    motion::{
        arc::{Shape, sweep},
        geometry::Point,
    },
};
pub use arc::arc;
pub use figures::Figures;
pub use line::line;

/// Steps of X, Y and Z in a tick, each -1, 0 or 1.
pub type Step = [i8; 3];

/// A place in steps from the machine's zero.
pub type Place = [i64; 3];

/// The farthest place in steps.
const FARTHEST: f64 = 2_147_483_647.0;
/// The least seconds of a tick.
const SHORTEST: f64 = 1e-3;

/// The kind of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MoveKind {
    /// G00
    Rapid,
    /// G01
    Line,
    /// G02
    Clockwise,
    /// G03
    Counterclockwise,
}

/// The figures of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// The line of the program.
    pub line: u32,
    /// The kind.
    pub kind: MoveKind,
    /// The length of the programmed path in inches.
    pub length: f64,
    /// The number of ticks.
    pub ticks: u64,
    /// The seconds of each tick.
    pub seconds: f64,
}

/// Resolution and bounds of T-mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The steps of an inch.
    pub scale: f64,
    /// The speed of rapid moves, and of moves before the first feed, in inches per minute.
    pub rapid: f64,
    /// The most ticks of a program.
    pub limit: u64,
}

impl Default for Resolution {
    fn default() -> Self {
        Self { scale: 4000.0, rapid: 15.0, limit: 100_000_000 }
    }
}

/// Follows the calls of a program.
pub struct Ticks {
    frame: Frame,
    resolution: Resolution,
    /// Inches per minute.
    feed: f64,
    /// The place in machine coordinates and inches.
    at: Position,
    place: Place,
    count: u64,
}

impl Ticks {
    /// Begins where the interpreter is, in program coordinates and units.
    ///
    /// # Errors
    /// The place is too far away.
    pub fn new(frame: Frame, position: Position, resolution: Resolution) -> Result<Self, Problem> {
        let at = frame.machine(position).scaled(frame.unit.to(Unit::Inch));
        let place = steps(at, resolution.scale)?;
        Ok(Self { frame, resolution, feed: resolution.rapid, at, place, count: 0 })
    }

    /// Returns the place in steps.
    pub fn place(&self) -> Place {
        self.place
    }

    /// Follows a call. Hands out each tick of its move, and returns the figures of the move.
    ///
    /// # Errors
    /// The call moves other axes than X, Y and Z or along another curve, goes too far, or has too many ticks.
    pub fn follow(
        &mut self,
        issued: &Issued,
        each: &mut dyn FnMut(Step),
    ) -> Result<Option<Move>, Problem> {
        self.frame.apply(&issued.call);
        let lacks = |what| Err(Problem::NoTicks { what });
        let (kind, end) = match &issued.call {
            Call::StraightTraverse(end) => (MoveKind::Rapid, *end),
            Call::StraightFeed(end) => (MoveKind::Line, *end),
            Call::ArcFeed { plane: Plane::Xy, end, centre_first, centre_second, turns } => {
                let kind =
                    if *turns < 0 { MoveKind::Clockwise } else { MoveKind::Counterclockwise };
                if turns.unsigned_abs() != 1 {
                    return lacks("arcs of more than one turn");
                }
                let centre = Point::new(*centre_first, *centre_second);
                return self.round(issued.line, kind, *end, centre, each).map(Some);
            }
            Call::ArcFeed { .. } => return lacks("arcs in other planes than XY"),
            Call::NurbsFeed { .. } => return lacks("splines"),
            Call::StraightProbe { .. } => return lacks("probes"),
            Call::RigidTap { .. } => return lacks("taps"),
            Call::SetFeedRate(feed) => {
                let inches = feed * self.frame.unit.to(Unit::Inch);
                self.feed = if inches > 0.0 { inches } else { self.resolution.rapid };
                return Ok(None);
            }
            _ => return Ok(None),
        };
        let from = self.place;
        let length = self.go_to(end)?;
        let mut delta = self.place;
        for (d, f) in delta.iter_mut().zip(from) {
            *d -= f;
        }
        let ticks = line(delta);
        let count = ticks.remaining();
        self.spend(count)?;
        ticks.for_each(each);
        Ok(Some(self.figures(issued.line, kind, length, count)))
    }

    /// Moves along an arc in XY, or a helix, to `end`.
    fn round(
        &mut self,
        line: u32,
        kind: MoveKind,
        end: Position,
        centre: Point,
        each: &mut dyn FnMut(Step),
    ) -> Result<Move, Problem> {
        let unit = self.frame.unit.to(Unit::Inch);
        let start = self.frame.program(self.at.scaled(Unit::Inch.to(self.frame.unit)));
        let mut middle = start;
        (middle.x, middle.y) = (centre.first, centre.second);
        let middle = steps(self.frame.machine(middle).scaled(unit), self.resolution.scale)?;
        let point = |p: Position| Point::new(p.x, p.y);
        let turns = if kind == MoveKind::Clockwise { -1 } else { 1 };
        let angle = sweep(point(start), point(end), Shape { centre, turns });
        let radius = point(start).minus(centre).length();
        let from = self.place;
        self.go_to(end)?;
        let to = self.place;
        let relative = |p: Place| {
            let [x, y, z] = p;
            let [cx, cy, _] = middle;
            [x - cx, y - cy, z]
        };
        // An arc has fewer ticks than steps of length, but for those of its ends.
        let around = whole(radius * unit * angle * self.resolution.scale);
        let [.., rise] = to;
        self.spend(around.saturating_add(rise.abs_diff(from[2])))?;
        let mut count = 0;
        let (from, to) = (relative(from), relative(to));
        arc::arc_of(from, to, kind == MoveKind::Clockwise, angle, &mut |step| {
            count += 1;
            each(step);
        });
        let flat = radius * unit * angle;
        let height = (end.z - start.z) * unit;
        Ok(self.figures(line, kind, libm::hypot(flat, height), count))
    }

    /// Sets the place, and returns the distance from the former one.
    fn go_to(&mut self, end: Position) -> Result<f64, Problem> {
        let at = self.frame.machine(end).scaled(self.frame.unit.to(Unit::Inch));
        let moved = at - self.at;
        let other = |axis: &Axis| !matches!(axis, Axis::X | Axis::Y | Axis::Z);
        if Axis::ALL.iter().filter(|a| other(a)).any(|a| moved[*a] != 0.0) {
            return Err(Problem::NoTicks { what: "axes but X, Y and Z" });
        }
        self.place = steps(at, self.resolution.scale)?;
        self.at = at;
        Ok(libm::hypot(libm::hypot(moved.x, moved.y), moved.z))
    }

    /// Counts ticks before they are made.
    fn spend(&mut self, ticks: u64) -> Result<(), Problem> {
        self.count = self.count.saturating_add(ticks);
        let limit = self.resolution.limit;
        if self.count > limit { Err(Problem::TicksTooMany { limit }) } else { Ok(()) }
    }

    fn figures(&self, line: u32, kind: MoveKind, length: f64, ticks: u64) -> Move {
        let speed = if kind == MoveKind::Rapid { self.resolution.rapid } else { self.feed };
        let seconds = length / speed * 60.0 / ticks.max(1) as f64;
        let seconds = if seconds > SHORTEST { seconds } else { SHORTEST };
        Move { line, kind, length, ticks, seconds }
    }
}

/// Returns a place in steps; halves are rounded away from zero.
fn steps(inches: Position, scale: f64) -> Result<Place, Problem> {
    let one = |v: f64| {
        let rounded = libm::round(v * scale);
        #[expect(clippy::cast_possible_truncation, reason = "within the farthest place")]
        (-FARTHEST..=FARTHEST).contains(&rounded).then_some(rounded as i64)
    };
    match (one(inches.x), one(inches.y), one(inches.z)) {
        (Some(x), Some(y), Some(z)) => Ok([x, y, z]),
        _ => Err(Problem::TicksTooFar),
    }
}

/// Returns the whole part of a number of ticks.
fn whole(ticks: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
    let whole = ticks as u64;
    whole
}
