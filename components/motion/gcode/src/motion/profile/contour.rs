//! Lines and arcs of a profile: offsets, corners, crossings.

use crate::{
    error::Problem,
    motion::geometry::{Point, circles, line_circle, nearest},
};

/// Distances below this are none, in program units.
pub(super) const NEAR: f64 = 1e-9;

/// The circle of an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arc {
    pub(crate) centre: Point,
    /// The arc turns to the left.
    pub(crate) left: bool,
}

/// A piece of a profile: a line, or an arc of less than a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) from: Point,
    pub(crate) to: Point,
    pub(crate) arc: Option<Arc>,
}

impl Piece {
    pub(crate) fn line(from: Point, to: Point) -> Self {
        Self { from, to, arc: None }
    }

    /// Returns the piece in another frame.
    pub(super) fn mapped(&self, map: impl Fn(Point) -> Point, mirrored: bool) -> Self {
        let arc = self.arc.map(|a| Arc { centre: map(a.centre), left: a.left != mirrored });
        Self { from: map(self.from), to: map(self.to), arc }
    }

    /// Tells whether the piece has no length; an arc is never a whole turn.
    pub(super) fn is_short(&self) -> bool {
        self.to.minus(self.from).length() < NEAR
    }

    /// Returns the unit direction at one of its points.
    pub(super) fn direction(&self, at: Point) -> Point {
        let out = match self.arc {
            None => self.to.minus(self.from),
            Some(arc) if arc.left => at.minus(arc.centre).left(),
            Some(arc) => Point::default().minus(at.minus(arc.centre).left()),
        };
        out.unit().unwrap_or_default()
    }

    fn radius(&self) -> f64 {
        self.arc.map_or(0.0, |a| self.from.minus(a.centre).length())
    }

    /// Returns the piece moved to its left by `distance`, or `None` if the arc has no radius left.
    pub(super) fn offset(&self, distance: f64) -> Option<Self> {
        let moved = |p: Point| p.plus(self.direction(p).left(), distance);
        let (from, to) = (moved(self.from), moved(self.to));
        if let Some(arc) = self.arc {
            let radius = if arc.left { self.radius() - distance } else { self.radius() + distance };
            if radius <= NEAR {
                return None;
            }
        }
        Some(Self { from, to, arc: self.arc })
    }

    /// Returns the share of a point of its circle or line: 0 at the begin, 1 at the end.
    fn share(&self, at: Point) -> f64 {
        match self.arc {
            None => {
                let way = self.to.minus(self.from);
                let square = way.dot(way);
                if square > 0.0 { at.minus(self.from).dot(way) / square } else { 0.0 }
            }
            Some(arc) => {
                let angle = |p: Point| {
                    let (a, b) = (self.from.minus(arc.centre), p.minus(arc.centre));
                    let angle = libm::atan2(a.cross(b), a.dot(b));
                    let angle = if arc.left { angle } else { -angle };
                    if angle < 0.0 { angle + core::f64::consts::TAU } else { angle }
                };
                let whole = angle(self.to);
                let part = angle(at);
                // A place just before the begin is no whole turn away.
                let part = if part > core::f64::consts::TAU - 1e-7 { 0.0 } else { part };
                if whole > 0.0 { part / whole } else { 0.0 }
            }
        }
    }

    /// Tells whether a point of its circle or line is on it.
    fn holds(&self, at: Point) -> bool {
        (-1e-7..=1.0 + 1e-7).contains(&self.share(at))
    }

    /// Returns the meeting points of the whole lines and circles of two pieces.
    fn meetings(&self, other: &Self) -> Option<[Point; 2]> {
        match (self.arc, other.arc) {
            (None, None) => {
                let (a, b) = (self.direction(self.from), other.direction(other.from));
                let cross = a.cross(b);
                if libm::fabs(cross) < NEAR {
                    return None;
                }
                let along = other.from.minus(self.from).cross(b) / cross;
                let at = self.from.plus(a, along);
                Some([at, at])
            }
            (None, Some(arc)) => {
                line_circle(self.from, self.direction(self.from), arc.centre, other.radius())
            }
            (Some(arc), None) => {
                line_circle(other.from, other.direction(other.from), arc.centre, self.radius())
            }
            (Some(a), Some(b)) => circles(a.centre, self.radius(), b.centre, other.radius()),
        }
    }

    /// Returns the crossing of two pieces that both hold, the one nearest to `corner`.
    fn crossing(&self, other: &Self, corner: Point) -> Option<Point> {
        let [a, b] = self.meetings(other)?;
        let both = |p: Point| self.holds(p) && other.holds(p);
        match (both(a), both(b)) {
            (true, true) => Some(nearest([a, b], corner)),
            (true, false) => Some(a),
            (false, true) => Some(b),
            (false, false) => None,
        }
    }

    /// Returns the place on the piece at a level; the first one.
    pub(super) fn at_level(&self, level: f64) -> Option<Point> {
        let candidates = match self.arc {
            None => {
                let rise = self.to.second - self.from.second;
                if libm::fabs(rise) < NEAR {
                    return (libm::fabs(level - self.from.second) < NEAR).then_some(self.from);
                }
                let share = (level - self.from.second) / rise;
                let at = self.from.plus(self.to.minus(self.from), share);
                [at, at]
            }
            Some(arc) => {
                let height = level - arc.centre.second;
                let square = self.radius() * self.radius() - height * height;
                let half = libm::sqrt(if square < 0.0 && square > -NEAR { 0.0 } else { square });
                if half.is_nan() {
                    return None;
                }
                let at = |h: f64| Point::new(arc.centre.first + h, level);
                [at(-half), at(half)]
            }
        };
        let mut held: Vec<Point> = candidates.into_iter().filter(|p| self.holds(*p)).collect();
        held.sort_by(|a, b| self.share(*a).total_cmp(&self.share(*b)));
        held.first().map(|p| Point::new(p.first, level))
    }

    /// Returns the part up to a place, and the part from it.
    pub(super) fn split(&self, at: Point) -> (Self, Self) {
        (Self { to: at, ..*self }, Self { from: at, ..*self })
    }

    /// Returns the parts that rise or fall throughout.
    pub(super) fn monotone(&self) -> Vec<Self> {
        let Some(arc) = self.arc else { return vec![*self] };
        let radius = self.radius();
        let mut cuts: Vec<Point> = [-radius, radius]
            .into_iter()
            .map(|h| Point::new(arc.centre.first, arc.centre.second + h))
            .filter(|p| (1e-9..=1.0 - 1e-9).contains(&self.share(*p)))
            .collect();
        cuts.sort_by(|a, b| self.share(*a).total_cmp(&self.share(*b)));
        let mut out = Vec::new();
        let mut rest = *self;
        for cut in cuts {
            let (before, after) = rest.split(cut);
            out.push(before);
            rest = after;
        }
        out.push(rest);
        out
    }

    /// Tells whether the piece never goes back.
    fn is_forward(&self) -> bool {
        if self.to.first < self.from.first - 1e-6 {
            return false;
        }
        let Some(arc) = self.arc else { return true };
        let radius = self.radius();
        [-radius, radius].into_iter().all(|h| {
            let p = Point::new(arc.centre.first + h, arc.centre.second);
            !(1e-6..=1.0 - 1e-6).contains(&self.share(p))
        })
    }
}

/// Tells whether a profile in Z and X goes along Z throughout, either way.
pub(super) fn goes_forward(pieces: &[Piece]) -> bool {
    let back = |p: Point| Point::new(-p.first, p.second);
    pieces.iter().all(Piece::is_forward) || pieces.iter().all(|p| p.mapped(back, true).is_forward())
}

/// Checks that a profile never goes back.
pub(super) fn check_forward(pieces: &[Piece]) -> Result<(), Problem> {
    if pieces.iter().all(Piece::is_forward) { Ok(()) } else { Err(Problem::ProfileGoesBack) }
}

/// Returns a profile moved to its left: around outer corners it goes in arcs, inner corners are cut off.
pub(super) fn offset(pieces: &[Piece], distance: f64) -> Vec<Piece> {
    let mut out: Vec<Piece> = Vec::new();
    if distance == 0.0 {
        return pieces.to_vec();
    }
    let mut previous: Option<&Piece> = None;
    for piece in pieces {
        let Some(moved) = piece.offset(distance) else { continue };
        let corner = piece.from;
        if let Some(before) = previous {
            let turn = before.direction(corner).cross(piece.direction(corner));
            let outer = if distance > 0.0 { turn < -1e-9 } else { turn > 1e-9 };
            if outer {
                let from = out.last().map_or(moved.from, |p| p.to);
                let arc = Arc { centre: corner, left: distance < 0.0 };
                out.push(Piece { from, to: moved.from, arc: Some(arc) });
                out.push(moved);
            } else {
                join(&mut out, moved, corner);
            }
        } else {
            out.push(moved);
        }
        previous = Some(piece);
    }
    out
}

/// Adds a piece behind those that it cuts off.
fn join(out: &mut Vec<Piece>, mut piece: Piece, corner: Point) {
    loop {
        let alone = out.len() == 1;
        let Some(last) = out.last_mut() else { break };
        if last.to.minus(piece.from).length() < NEAR {
            break;
        }
        if let Some(at) = last.crossing(&piece, corner) {
            last.to = at;
            piece.from = at;
            break;
        }
        // What lies behind the inner corner has no place on the moved profile.
        if alone {
            let gap = Piece::line(last.to, piece.from);
            out.push(gap);
            break;
        }
        out.pop();
    }
    out.push(piece);
}

/// Puts a fillet or chamfer between two pieces. Returns the shortened pieces and what lies between.
pub(super) fn round(
    a: Piece,
    b: Piece,
    radius: f64,
    chamfer: bool,
) -> Result<(Piece, Piece, Piece), Problem> {
    let corner = a.to;
    let turn = a.direction(corner).cross(b.direction(corner));
    if libm::fabs(turn) < NEAR {
        return Ok((a, Piece::line(corner, corner), b));
    }
    let side = if turn > 0.0 { radius } else { -radius };
    let moved = a.offset(side).zip(b.offset(side));
    let centre = moved.and_then(|(a, b)| a.crossing(&b, corner)).ok_or(Problem::ProfileGoesBack)?;
    let touch = |piece: &Piece| match piece.arc {
        None => {
            let way = piece.direction(piece.from);
            piece.from.plus(way, centre.minus(piece.from).dot(way))
        }
        Some(arc) => {
            let out = centre.minus(arc.centre).unit().unwrap_or_default();
            arc.centre.plus(out, piece.radius())
        }
    };
    let (from, to) = (touch(&a), touch(&b));
    let arc = (!chamfer).then_some(Arc { centre, left: turn > 0.0 });
    Ok((Piece { to: from, ..a }, Piece { from, to, arc }, Piece { from: to, ..b }))
}
