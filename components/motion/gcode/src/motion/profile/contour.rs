//! Lines and arcs of a profile: their places, corners, crossings.

use crate::{
    error::Problem,
    motion::geometry::{Course, Point, nearest},
};

/// Distances below this are none, in program units.
pub(super) const NEAR: f64 = 1e-9;

/// Shorter pieces are left out of a moved profile, in program units.
pub(super) const SNAP: f64 = 1e-7;

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
    /// The line of the program that it comes from; 0 for none.
    pub(crate) line: u32,
}

impl Piece {
    pub(crate) fn straight(from: Point, to: Point) -> Self {
        Self { from, to, arc: None, line: 0 }
    }

    /// Returns an arc whose ends have the same distance from its centre, which a program states to a few decimals.
    pub(super) fn exact(self) -> Self {
        let Some(arc) = self.arc else { return self };
        let chord = self.to.minus(self.from);
        let (middle, square) = (self.from.plus(chord, 0.5), chord.dot(chord));
        let aside = arc.centre.minus(middle).dot(chord);
        if square <= 0.0 || libm::fabs(aside) <= NEAR * libm::sqrt(square) {
            return self;
        }
        let centre = arc.centre.plus(chord, -aside / square);
        Self { arc: Some(Arc { centre, ..arc }), ..self }
    }

    /// Returns the piece in another frame.
    pub(super) fn mapped(&self, map: impl Fn(Point) -> Point, mirrored: bool) -> Self {
        let arc = self.arc.map(|a| Arc { centre: map(a.centre), left: a.left != mirrored });
        Self { from: map(self.from), to: map(self.to), arc, ..*self }
    }

    /// Tells whether the piece has no length; an arc is never a whole turn.
    pub(super) fn is_short(&self) -> bool {
        self.to.minus(self.from).length() < NEAR
    }

    /// Tells whether an arc is so short that motion could take it for none or a full turn.
    pub(super) fn is_nearly_straight(&self) -> bool {
        self.to.minus(self.from).length() < 1e-5 * self.radius()
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

    pub(super) fn radius(&self) -> f64 {
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
        Some(Self { from, to, ..*self })
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

    fn course(&self) -> Course {
        match self.arc {
            None => Course::Line(self.from, self.direction(self.from)),
            Some(arc) => Course::Circle(arc.centre, self.radius()),
        }
    }

    /// Returns the meeting points of the whole lines and circles of two pieces.
    fn meetings(&self, other: &Self) -> Option<[Point; 2]> {
        self.course().meetings(other.course(), NEAR)
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

    /// Returns the place at a level of a piece that rises or falls throughout.
    pub(super) fn at_level(&self, level: f64) -> Point {
        let along = match self.arc {
            None => {
                let rise = self.to.second - self.from.second;
                let share = if rise == 0.0 { 0.0 } else { (level - self.from.second) / rise };
                self.from.first + share * (self.to.first - self.from.first)
            }
            Some(arc) => {
                let (radius, height) = (self.radius(), level - arc.centre.second);
                let square = (radius - height) * (radius + height);
                let half = if square > 0.0 { libm::sqrt(square) } else { 0.0 };
                // Such a piece lies on one side of its centre.
                let before = self.from.first + self.to.first < 2.0 * arc.centre.first;
                arc.centre.first + if before { -half } else { half }
            }
        };
        let (low, high) = (self.from.first, self.to.first);
        let (low, high) = if low <= high { (low, high) } else { (high, low) };
        Point::new(along.max(low).min(high), level)
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
            .filter(|p| (0.0..=1.0).contains(&self.share(*p)))
            .filter(|p| [self.from, self.to].iter().all(|e| p.minus(*e).length() >= SNAP))
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

/// Checks that a profile never goes back. Returns the line that does.
pub(super) fn check_forward(pieces: &[Piece]) -> Result<(), u32> {
    pieces.iter().find(|p| !p.is_forward()).map_or(Ok(()), |p| Err(p.line))
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
        return Ok((a, Piece::straight(corner, corner), b));
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
    let between = Piece { from, to, arc, line: a.line };
    Ok((Piece { to: from, ..a }, between, Piece { from: to, ..b }))
}
